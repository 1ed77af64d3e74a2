//! Files as a part of a scene reads them that is made beside others.

use crate::lang::source::SourceMap;
use crate::loading::Loading;
use bhs_core::diagnostics::Span;
use bhs_core::params::{Decode, Decoded, Files};
use std::any::TypeId;
use std::path::Path;
use std::sync::{Arc, Mutex, PoisonError};

impl SourceMap {
    /// How far loading has come.
    pub fn loading(&self) -> &Arc<Loading> {
        &self.loading
    }

    /// The size of the file that the text at `span` calls `path`, if that is known (bytes); else 0.
    pub(in crate::lang) fn size(&self, path: &str, span: Span) -> u64 {
        let full = self.locate(path, span);
        match &self.memory {
            Some(files) => files.get(&full).map_or(0, |bytes| bytes.len() as u64),
            None => full.metadata().map_or(0, |found| found.len()),
        }
    }
}

/// Whether a place comes before another one; what the command line names, which has none, comes first.
pub(super) fn comes_before(a: Option<Span>, b: Option<Span>) -> bool {
    let key = |span: Option<Span>| span.map(|s| (s.file, s.start));
    key(a) < key(b)
}

/// Reads files for one part of a scene, and keeps what they hold, which is no part of the scene's hash before it is the part's turn.
pub(in crate::lang) struct Side<'s> {
    sources: &'s SourceMap,
    /// In the order of reading; `None`: the part has asked for what others may take out of the same file, and must wait for its turn.
    read: Mutex<Option<Vec<Vec<u8>>>>,
}

impl<'s> Side<'s> {
    /// One that has read nothing.
    pub fn new(sources: &'s SourceMap) -> Self {
        Self { sources, read: Mutex::new(Some(Vec::new())) }
    }

    /// What has been read; `None`: what was made of it does not count.
    pub fn finish(self) -> Option<Vec<Vec<u8>>> {
        self.read.into_inner().unwrap_or_else(PoisonError::into_inner)
    }

    fn content(&self, path: &str, span: Span) -> Result<Vec<u8>, String> {
        self.sources.content(&self.sources.locate(path, span), Path::new(path), Some(span))
    }

    fn keep(&self, content: Vec<u8>) {
        if let Some(read) = &mut *self.read.lock().unwrap_or_else(PoisonError::into_inner) {
            read.push(content);
        }
    }
}

impl Files for Side<'_> {
    fn read(&self, path: &str, span: Span) -> Result<Vec<u8>, String> {
        let content = self.content(path, span)?;
        self.keep(content.clone());
        Ok(content)
    }

    fn decode(&self, path: &str, span: Span, kind: TypeId, decode: Decode) -> Result<Decoded, String> {
        let content = self.content(path, span)?;
        let made = self.sources.decoded(&content, kind, decode);
        self.keep(content);
        made
    }

    fn share(&self, _: &str, _: Span, _: TypeId, _: Decode) -> Result<Decoded, String> {
        *self.read.lock().unwrap_or_else(PoisonError::into_inner) = None;
        Err("it is made later".to_owned())
    }
}
