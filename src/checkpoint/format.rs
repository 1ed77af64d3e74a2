//! The file of a checkpoint: sections of bytes, each with its checksum, one after the other.
//!
//! | part | bytes |
//! |---|---|
//! | signature | `\x89BHS\r\n\x1a\n` |
//! | version of the format | 4 |
//! | sections | each: kind (4 letters), length (8), content, CRC-32 of the three (4) |
//!
//! Numbers are little-endian. Reader and writer hold one section at a time, whatever the size of the file. What the sections are stands in
//! [`crate::checkpoint`].

use std::io::{ErrorKind, Read, Write};

/// The first bytes of the file. As those of PNG, they do not survive what breaks binary files on their way.
const SIGNATURE: [u8; 8] = *b"\x89BHS\r\n\x1a\n";
/// The version of the format.
const VERSION: u32 = 3;

/// What a section is: four letters.
pub type SectionKind = [u8; 4];

/// Why a file cannot be read.
#[derive(Debug, thiserror::Error)]
pub enum ReadError {
    /// It cannot be read at all.
    #[error(transparent)]
    Io(#[from] std::io::Error),
    /// It is not what was written.
    #[error("{0}")]
    Damaged(String),
    /// It is a part of what was written.
    #[error("it ends early")]
    CutShort,
    /// It is written by a program that knows more.
    #[error("it has version {0} of the format, and this program knows version {VERSION}")]
    Version(u32),
}

/// Writes the sections of a file.
pub struct Writer<W>(W);

impl<W: Write> Writer<W> {
    /// Begins the file.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn new(mut to: W) -> std::io::Result<Self> {
        to.write_all(&SIGNATURE)?;
        to.write_all(&VERSION.to_le_bytes())?;
        Ok(Self(to))
    }

    /// Adds a section; its content is that of `parts`, joined.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn section(&mut self, kind: SectionKind, parts: &[&[u8]]) -> std::io::Result<()> {
        let length: usize = parts.iter().map(|p| p.len()).sum();
        let mut checksum = crc32fast::Hasher::new();
        let length = (length as u64).to_le_bytes();
        for part in [&kind[..], &length[..]].iter().chain(parts) {
            checksum.update(part);
            self.0.write_all(part)?;
        }
        self.0.write_all(&checksum.finalize().to_le_bytes())
    }
}

/// Reads the sections of a file.
pub struct Reader<R>(R);

impl<R: Read> Reader<R> {
    /// Begins with a file.
    ///
    /// # Errors
    /// If it is no such file.
    pub fn new(from: R) -> Result<Self, ReadError> {
        Self::of("checkpoint", from)
    }

    /// Begins with a file that is `what`, in words.
    ///
    /// # Errors
    /// If it is no such file.
    pub fn of(what: &str, mut from: R) -> Result<Self, ReadError> {
        let mut signature = [0; 8];
        read_exact(&mut from, &mut signature)?;
        if signature != SIGNATURE {
            return Err(ReadError::Damaged(format!("it is no {what}")));
        }
        let mut version = [0; 4];
        read_exact(&mut from, &mut version)?;
        match u32::from_le_bytes(version) {
            VERSION => Ok(Self(from)),
            other => Err(ReadError::Version(other)),
        }
    }

    /// The next section: its kind and its content.
    ///
    /// # Errors
    /// If there is none, or its checksum is wrong.
    pub fn section(&mut self) -> Result<(SectionKind, Vec<u8>), ReadError> {
        let (mut kind, mut length, mut expected) = ([0; 4], [0; 8], [0; 4]);
        read_exact(&mut self.0, &mut kind)?;
        read_exact(&mut self.0, &mut length)?;
        // Memory comes with what is read: a false length asks for none.
        let (count, mut content) = (u64::from_le_bytes(length), Vec::new());
        (&mut self.0).take(count).read_to_end(&mut content)?;
        if content.len() as u64 != count {
            return Err(ended_early());
        }
        read_exact(&mut self.0, &mut expected)?;
        let mut checksum = crc32fast::Hasher::new();
        [&kind[..], &length[..], &content].iter().for_each(|part| checksum.update(part));
        if checksum.finalize() != u32::from_le_bytes(expected) {
            return Err(ReadError::Damaged("a checksum is wrong".to_owned()));
        }
        Ok((kind, content))
    }

    /// Makes sure that nothing comes after the last section.
    ///
    /// # Errors
    /// If something does.
    pub fn end(mut self) -> Result<(), ReadError> {
        match self.0.read(&mut [0])? {
            0 => Ok(()),
            _ => Err(ReadError::Damaged("something comes after its end".to_owned())),
        }
    }
}

fn read_exact(from: &mut impl Read, into: &mut [u8]) -> Result<(), ReadError> {
    from.read_exact(into).map_err(|e| if e.kind() == ErrorKind::UnexpectedEof { ended_early() } else { e.into() })
}

fn ended_early() -> ReadError {
    ReadError::CutShort
}
