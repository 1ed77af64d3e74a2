//! What viewers read: the protocol of tev (`src/Ipc.cpp` of <https://github.com/Tom94/tev>), which HDRView speaks too.
//!
//! A packet is its size in bytes, these four included, its kind in one byte, and what belongs to it; all numbers are little-endian, texts end
//! with a zero byte.

/// Kinds of packets.
const CREATE_IMAGE: u8 = 4;
const UPDATE_IMAGE_V3: u8 = 6;

/// A picture, or a part of one.
pub struct Pixels<'a> {
    /// Column and row of the first pixel.
    pub at: [u32; 2],
    /// Width and height (pixels).
    pub size: [u32; 2],
    /// Row by row from the top, the channels of a pixel together.
    pub data: &'a [f32],
}

/// Makes a black image, in place of one of the same name. `grab`: the viewer shows it at once.
pub fn create_image(name: &str, grab: bool, [width, height]: [u32; 2], channels: &[String]) -> Vec<u8> {
    let mut packet = Packet::new(CREATE_IMAGE, grab, name);
    packet.numbers(&[width, height, channels.len() as u32]);
    packet.texts(channels);
    packet.finish()
}

/// Changes a part of an image. The viewer keeps what it shows.
pub fn update_image(name: &str, channels: &[String], pixels: &Pixels) -> Vec<u8> {
    let n = channels.len() as i64;
    let mut packet = Packet::new(UPDATE_IMAGE_V3, false, name);
    packet.0.reserve(64 * channels.len() + 4 * pixels.data.len());
    packet.numbers(&[channels.len() as u32]);
    packet.texts(channels);
    packet.numbers(&pixels.at);
    packet.numbers(&pixels.size);
    // Of each channel: where its first number stands, and how far it is to the next.
    (0..n).for_each(|offset| packet.0.extend_from_slice(&offset.to_le_bytes()));
    (0..n).for_each(|_| packet.0.extend_from_slice(&n.to_le_bytes()));
    pixels.data.iter().for_each(|value| packet.0.extend_from_slice(&value.to_le_bytes()));
    packet.finish()
}

/// A packet under way.
struct Packet(Vec<u8>);

impl Packet {
    fn new(kind: u8, grab: bool, name: &str) -> Self {
        let mut packet = Self(vec![0, 0, 0, 0, kind, u8::from(grab)]);
        packet.text(name);
        packet
    }

    fn numbers(&mut self, numbers: &[u32]) {
        numbers.iter().for_each(|n| self.0.extend_from_slice(&n.to_le_bytes()));
    }

    fn text(&mut self, text: &str) {
        self.0.extend(text.bytes().filter(|byte| *byte != 0));
        self.0.push(0);
    }

    fn texts(&mut self, texts: &[String]) {
        texts.iter().for_each(|text| self.text(text));
    }

    fn finish(mut self) -> Vec<u8> {
        let size = self.0.len() as u32;
        self.0[..4].copy_from_slice(&size.to_le_bytes());
        self.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// By hand, from the description of the protocol.
    #[test]
    fn packets_are_as_tev_reads_them() {
        let channels = ["R".to_owned(), "N.X".to_owned()];
        let mut expected = vec![34, 0, 0, 0, 4, 1, b'a', b'.', b'e', b'x', b'r', 0];
        expected.extend([3, 0, 0, 0, 2, 0, 0, 0, 2, 0, 0, 0, b'R', 0, b'N', b'.', b'X', 0]);
        expected[0] = expected.len() as u8;
        assert_eq!(create_image("a.exr", true, [3, 2], &channels), expected);

        let pixels = Pixels { at: [1, 5], size: [1, 2], data: &[1.0, -2.0, 0.5, 0.0] };
        let mut expected = vec![0, 0, 0, 0, 6, 0, b'a', 0, 2, 0, 0, 0, b'R', 0, b'N', b'.', b'X', 0];
        expected.extend([1, 0, 0, 0, 5, 0, 0, 0, 1, 0, 0, 0, 2, 0, 0, 0]);
        for number in [0i64, 1, 2, 2] {
            expected.extend(number.to_le_bytes());
        }
        for value in [1.0f32, -2.0, 0.5, 0.0] {
            expected.extend(value.to_le_bytes());
        }
        expected[0] = expected.len() as u8;
        assert_eq!(update_image("a", &channels, &pixels), expected);
    }
}
