//! A viewer as tev is one: it listens, and reads packets as tev's `src/Ipc.cpp` does.

use std::collections::BTreeMap;
use std::io::{ErrorKind, Read};
use std::net::{SocketAddr, TcpListener, TcpStream};
use std::time::Duration;

/// Where a viewer listens.
pub struct Viewer(TcpListener);

/// An image as the viewer has it.
#[derive(Clone, Debug, PartialEq)]
pub struct Image {
    /// Width and height.
    pub size: [usize; 2],
    /// Each channel by its name, row by row.
    pub channels: BTreeMap<String, Vec<f32>>,
    /// How often it was made.
    pub created: usize,
    /// The windows that were changed: x, y, width, height.
    pub updates: Vec<[usize; 4]>,
}

/// What a viewer has been sent.
#[derive(Clone, Debug, Default)]
pub struct Seen {
    /// All images by their names.
    pub images: BTreeMap<String, Image>,
    /// The name of the image that is shown.
    pub shown: String,
}

impl Viewer {
    /// Listens at a free port.
    pub fn new() -> Self {
        Self(TcpListener::bind("127.0.0.1:0").expect("a free port"))
    }

    /// Listens there, as soon as nobody else does.
    pub fn at(address: SocketAddr) -> Self {
        for _ in 0..1000 {
            if let Ok(listener) = TcpListener::bind(address) {
                return Self(listener);
            }
            std::thread::sleep(Duration::from_millis(20));
        }
        panic!("{address} is taken");
    }

    /// Where it listens.
    pub fn address(&self) -> SocketAddr {
        self.0.local_addr().expect("it listens")
    }

    /// What `--display-server` is told.
    pub fn flag(&self) -> String {
        format!("--display-server={}", self.address())
    }

    /// Waits for somebody.
    pub fn accept(&self) -> TcpStream {
        self.0.accept().expect("somebody comes").0
    }
}

/// Reads all packets until the other side is done, or `enough` says so.
pub fn read(stream: &mut TcpStream, mut enough: impl FnMut(&Seen) -> bool) -> Seen {
    let mut seen = Seen::default();
    while let Some(packet) = packet(stream) {
        seen.take(&packet);
        if enough(&seen) {
            break;
        }
    }
    seen
}

/// The next packet without its size; `None` if there is none any more.
fn packet(stream: &mut TcpStream) -> Option<Vec<u8>> {
    let mut size = [0; 4];
    match stream.read_exact(&mut size) {
        Ok(()) => {}
        Err(error) if [ErrorKind::UnexpectedEof, ErrorKind::ConnectionReset].contains(&error.kind()) => return None,
        Err(error) => panic!("{error}"),
    }
    let size = u32::from_le_bytes(size) as usize;
    assert!((6..1 << 30).contains(&size), "a packet of {size} bytes");
    let mut packet = vec![0; size - 4];
    stream.read_exact(&mut packet).ok()?;
    Some(packet)
}

/// A packet that is being read.
struct Reader<'a>(&'a [u8]);

impl Reader<'_> {
    fn bytes<const N: usize>(&mut self) -> [u8; N] {
        let (head, rest) = self.0.split_first_chunk().expect("the packet is long enough");
        self.0 = rest;
        *head
    }

    fn int(&mut self) -> usize {
        usize::try_from(i32::from_le_bytes(self.bytes())).expect("not negative")
    }

    fn long(&mut self) -> usize {
        usize::try_from(i64::from_le_bytes(self.bytes())).expect("not negative")
    }

    fn text(&mut self) -> String {
        let end = self.0.iter().position(|b| *b == 0).expect("a text ends");
        let text = String::from_utf8(self.0[..end].to_vec()).expect("UTF-8");
        self.0 = &self.0[end + 1..];
        text
    }
}

impl Seen {
    fn take(&mut self, packet: &[u8]) {
        let mut from = Reader(packet);
        let [kind, grab] = from.bytes();
        let name = from.text();
        assert!(grab <= 1);
        match kind {
            4 => {
                let size = [from.int(), from.int()];
                let channels: Vec<String> = (0..from.int()).map(|_| from.text()).collect();
                assert!(from.0.is_empty(), "more than there should be");
                let created = self.images.get(&name).map_or(0, |i| i.created) + 1;
                let channels = channels.into_iter().map(|c| (c, vec![0.0; size[0] * size[1]])).collect();
                self.images.insert(name.clone(), Image { size, channels, created, updates: Vec::new() });
            }
            6 => {
                let image = self.images.get_mut(&name).unwrap_or_else(|| panic!("{name} was never made"));
                let n = from.int();
                let channels: Vec<String> = (0..n).map(|_| from.text()).collect();
                let window: [usize; 4] = std::array::from_fn(|_| from.int());
                let [x0, y0, width, height] = window;
                let offsets: Vec<usize> = (0..n).map(|_| from.long()).collect();
                let strides: Vec<usize> = (0..n).map(|_| from.long()).collect();
                let needed = offsets.iter().zip(&strides).map(|(o, s)| o + (width * height - 1) * s + 1).max();
                assert_eq!(Some(from.0.len()), needed.map(|n| 4 * n), "tev wants exactly as much");
                assert!(x0 + width <= image.size[0] && y0 + height <= image.size[1], "{window:?} in {:?}", image.size);
                let data: Vec<f32> = from.0.as_chunks::<4>().0.iter().map(|b| f32::from_le_bytes(*b)).collect();
                for ((channel, offset), stride) in channels.iter().zip(offsets).zip(strides) {
                    let own = image.channels.get_mut(channel).unwrap_or_else(|| panic!("there is no channel {channel}"));
                    for pixel in 0..width * height {
                        let (x, y) = (x0 + pixel % width, y0 + pixel / width);
                        own[y * image.size[0] + x] = data[offset + pixel * stride];
                    }
                }
                image.updates.push(window);
            }
            other => panic!("a packet of kind {other}"),
        }
        if grab == 1 {
            self.shown = name;
        }
    }

    /// That an image is what an EXR file holds: the same channels, to the bit.
    ///
    /// # Panics
    /// If it is not.
    pub fn assert_is(&self, name: &str, exr: &std::path::Path) {
        let picture = bhs::image::Picture::read_exr(exr).expect("a picture");
        let image = self.images.get(name).unwrap_or_else(|| panic!("{name} is not among {:?}", self.images.keys()));
        assert_eq!(image.size, picture.size);
        let mut names = picture.channels.clone();
        names.sort();
        assert!(image.channels.keys().eq(&names), "{:?} {names:?}", image.channels.keys());
        for (c, channel) in picture.channels.iter().enumerate() {
            let there = picture.data.iter().skip(c).step_by(names.len()).map(|v| v.to_bits());
            assert!(image.channels[channel].iter().map(|v| v.to_bits()).eq(there), "{channel} of {name} differs");
        }
    }
}
