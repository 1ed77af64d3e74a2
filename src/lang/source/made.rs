//! What is made of the files that a scene reads, and how long it is kept.

use crate::lang::source::SourceMap;
use bhs_core::diagnostics::Span;
use bhs_core::params::{Decode, Decoded, Files};
use std::any::TypeId;
use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

/// What has been made of files, for scenes that are made one after the other and read the same ones. It is found by the files' contents, so
/// that a file that changes meanwhile is read anew.
#[derive(Default)]
pub struct FileCache {
    made: Mutex<HashMap<(blake3::Hash, TypeId), Made>>,
    /// How often something was made, and not found.
    misses: AtomicUsize,
}

/// What has been made of a file, and whether it has been asked for lately.
type Made = (Decoded, bool);

impl FileCache {
    /// Forgets what nobody has asked for since this was last called.
    pub fn forget_unused(&self) {
        self.made.lock().unwrap_or_else(PoisonError::into_inner).retain(|_, (_, used)| std::mem::take(used));
    }

    /// How often something was made of a file.
    pub fn misses(&self) -> usize {
        self.misses.load(Ordering::Relaxed)
    }
}

impl std::fmt::Debug for FileCache {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        f.debug_struct("FileCache").field("misses", &self.misses()).finish_non_exhaustive()
    }
}

/// What has been made of files that several parts of one scene take something out of, by path and type: each is read once.
#[derive(Default)]
pub(super) struct Shared(Mutex<HashMap<(PathBuf, TypeId), Result<Decoded, String>>>);

impl std::fmt::Debug for Shared {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        f.debug_tuple("Shared").field(&self.0.lock().unwrap_or_else(PoisonError::into_inner).len()).finish()
    }
}

impl SourceMap {
    /// Lets go what several parts of a scene took out of the same files.
    pub(in crate::lang) fn forget_shared(&self) {
        self.shared.0.lock().unwrap_or_else(PoisonError::into_inner).clear();
    }

    /// What `decode` makes of a content, or has made of it before.
    pub(super) fn decoded(&self, content: &[u8], kind: TypeId, decode: Decode) -> Result<Decoded, String> {
        let Some(cache) = &self.cache else { return decode(content) };
        let key = (blake3::hash(content), kind);
        let made = || cache.made.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((made, used)) = made().get_mut(&key) {
            *used = true;
            return Ok(Arc::clone(made));
        }
        let new = decode(content)?;
        cache.misses.fetch_add(1, Ordering::Relaxed);
        made().insert(key, (Arc::clone(&new), true));
        Ok(new)
    }
}

impl Files for SourceMap {
    fn read(&self, path: &str, span: Span) -> Result<Vec<u8>, String> {
        let content = self.content(&self.locate(path, span), Path::new(path), Some(span))?;
        self.hash_content(&content);
        Ok(content)
    }

    fn decode(&self, path: &str, span: Span, kind: TypeId, decode: Decode) -> Result<Decoded, String> {
        self.decoded(&self.read(path, span)?, kind, decode)
    }

    fn share(&self, path: &str, span: Span, kind: TypeId, decode: Decode) -> Result<Decoded, String> {
        let key = (self.locate(path, span), kind);
        let made = || self.shared.0.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(made) = made().get(&key) {
            return made.clone();
        }
        let new = self.decode(path, span, kind, decode);
        made().insert(key, new.clone());
        new
    }
}
