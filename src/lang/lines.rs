//! Lines and columns of a text, found without going through the text for each.

/// Bytes of text for which the characters before them are kept.
const BLOCK: usize = 1024;

/// Where the lines of a text begin, and how many characters stand before each block of it.
#[derive(Clone, Debug)]
pub(super) struct Lines {
    /// Offsets of the first bytes of all lines.
    starts: Vec<u32>,
    /// Characters that begin before each block.
    characters: Vec<u32>,
}

impl Lines {
    /// The lines of a text of less than 4 GiB.
    pub fn new(text: &str) -> Self {
        let ends = text.bytes().enumerate().filter(|(_, b)| *b == b'\n');
        let starts = std::iter::once(0).chain(ends.map(|(i, _)| i as u32 + 1)).collect();
        let mut before = 0;
        let characters = text.as_bytes().chunks(BLOCK).map(|block| {
            let here = before;
            before += begun(block);
            here
        });
        Self { starts, characters: characters.collect() }
    }

    /// Line and column (in characters), both from 1, of the character of `text` that begins at a byte.
    pub fn place(&self, text: &str, offset: usize) -> (usize, usize) {
        let line = self.starts.partition_point(|start| *start as usize <= offset);
        let start = self.starts[line - 1] as usize;
        (line, self.characters_before(text, offset) - self.characters_before(text, start) + 1)
    }

    fn characters_before(&self, text: &str, offset: usize) -> usize {
        let block = (offset / BLOCK).min(self.characters.len().saturating_sub(1));
        let before = self.characters.get(block).map_or(0, |c| *c as usize);
        before + begun(&text.as_bytes()[block * BLOCK..offset]) as usize
    }
}

/// Characters that begin among bytes of UTF-8.
fn begun(bytes: &[u8]) -> u32 {
    bytes.iter().filter(|b| **b & 0xc0 != 0x80).count() as u32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_are_those_of_counting() {
        let long = "\u{e9}x\u{1f600}".repeat(700);
        for text in ["", "a", "\n", "a\n\u{e9}b\n", &long, &format!("{long}\n{long}\n\nend")] {
            let lines = Lines::new(text);
            for offset in (0..=text.len()).filter(|i| text.is_char_boundary(*i)) {
                let before = &text[..offset];
                let start = before.rfind('\n').map_or(0, |i| i + 1);
                let expected = (before.matches('\n').count() + 1, before[start..].chars().count() + 1);
                assert_eq!(lines.place(text, offset), expected, "{offset}");
            }
        }
    }
}
