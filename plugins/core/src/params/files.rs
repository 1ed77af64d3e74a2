//! Files as plugins read them.

use super::Context;
use crate::diagnostics::Span;
use std::any::{Any, TypeId};
use std::sync::Arc;

/// Files as plugins see them: the contract does no input or output itself.
pub trait Files {
    /// The whole content of the file that the text at `span` calls `path`; a relative path starts at the folder of the file
    /// that `span` lies in.
    ///
    /// # Errors
    /// What is wrong with the file, in words that can follow "cannot read `path`: ".
    fn read(&self, path: &str, span: Span) -> Result<Vec<u8>, String>;

    /// What `decode` makes of that content, which is of the type `kind`. Where several scenes are made one after the other, such as the frames of an
    /// animation, it may be what was made of the same content before: see [`Context::decode`].
    ///
    /// # Errors
    /// As [`Files::read`], and what `decode` finds wrong.
    fn decode(&self, path: &str, span: Span, kind: TypeId, decode: Decode) -> Result<Decoded, String> {
        let _ = kind;
        decode(&self.read(path, span)?)
    }

    /// As [`Files::decode`], for what several parts of one scene take out of the same file: it is read and made once, and kept while the scene is
    /// built.
    ///
    /// # Errors
    /// As [`Files::decode`].
    fn share(&self, path: &str, span: Span, kind: TypeId, decode: Decode) -> Result<Decoded, String> {
        self.decode(path, span, kind, decode)
    }
}

/// What has been made of a file.
pub type Decoded = Arc<dyn Any + Send + Sync>;

/// Makes something of a file's content, or says what is wrong with it.
pub type Decode<'a> = &'a dyn Fn(&[u8]) -> Result<Decoded, String>;

impl Context<'_> {
    /// What `decode` makes of the file that the text at `span` calls `path`. It depends on the content alone, and there is one way to make a `T`:
    /// frames of an animation share what is made.
    ///
    /// # Errors
    /// What is wrong with the file, in words that can follow "cannot read `path`: ".
    pub fn decode<T: Any + Send + Sync>(
        &self,
        path: &str,
        span: Span,
        decode: impl Fn(&[u8]) -> Result<T, String>,
    ) -> Result<Arc<T>, String> {
        downcast(self.files.decode(path, span, TypeId::of::<T>(), &|bytes| Ok(Arc::new(decode(bytes)?)))?)
    }

    /// The same for what other parts of the scene take out of the file too: see [`Files::share`].
    ///
    /// # Errors
    /// As [`Context::decode`].
    pub fn share<T: Any + Send + Sync>(
        &self,
        path: &str,
        span: Span,
        decode: impl Fn(&[u8]) -> Result<T, String>,
    ) -> Result<Arc<T>, String> {
        share(self.files, path, span, decode)
    }
}

/// [`Files::share`] of a type.
///
/// # Errors
/// As [`Context::decode`].
pub fn share<T: Any + Send + Sync>(
    files: &dyn Files,
    path: &str,
    span: Span,
    decode: impl Fn(&[u8]) -> Result<T, String>,
) -> Result<Arc<T>, String> {
    downcast(files.share(path, span, TypeId::of::<T>(), &|bytes| Ok(Arc::new(decode(bytes)?)))?)
}

fn downcast<T: Any + Send + Sync>(made: Decoded) -> Result<Arc<T>, String> {
    made.downcast().map_err(|_| "it is kept as something else, which is a fault of bhs".to_owned())
}
