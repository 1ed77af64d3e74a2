//! The images that a viewer is to have, and what of them it has.

use super::packet::{self, Pixels};
use crate::film::{Framebuffer, SeenTile};
use crate::image::Picture;
use std::collections::VecDeque;
use std::sync::{Arc, Mutex, PoisonError};

/// Memory that pictures may take which are only kept for viewers that come later (bytes).
const KEPT: usize = 256 << 20;
/// The largest packet: viewers count in signed 32-bit numbers, and keep it in memory.
const LARGEST: usize = 512 << 20;

/// All images, in the order of their first samples.
#[derive(Default)]
pub struct Images(VecDeque<Image>);

/// One image.
struct Image {
    name: String,
    size: [u32; 2],
    channels: Vec<String>,
    /// Where its tiles come from while it is rendered.
    frame: Option<Tiles>,
    /// What comes before the tiles, coarse, or all of it in the end.
    whole: Option<Arc<Picture>>,
    is_created: bool,
    is_whole_sent: bool,
}

/// The tiles of an image.
#[derive(Clone)]
struct Tiles {
    frame: Arc<Framebuffer>,
    /// What the viewer has seen of each.
    seen: Arc<Mutex<Vec<SeenTile>>>,
}

/// What is to be sent of an image.
pub struct Work {
    name: String,
    size: [u32; 2],
    channels: Vec<String>,
    create: bool,
    grab: bool,
    whole: Option<Arc<Picture>>,
    tiles: Option<Tiles>,
}

impl Images {
    /// An image of this name, size and channels, at the end of the list; one that is there already keeps what the viewer has of it.
    fn image(&mut self, name: &str, size: [u32; 2], channels: &[String]) -> &mut Image {
        let there = self.0.iter().position(|i| i.name == name).and_then(|at| self.0.remove(at));
        let new = || Image {
            name: name.to_owned(),
            size,
            channels: channels.to_vec(),
            frame: None,
            whole: None,
            is_created: false,
            is_whole_sent: false,
        };
        let same = there.filter(|i| i.size == size && i.channels == channels);
        self.0.push_back(same.map_or_else(new, |same| Image { frame: None, ..same }));
        let last = self.0.len() - 1;
        &mut self.0[last]
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// An image whose tiles are being rendered.
    pub fn begin(&mut self, name: &str, frame: &Arc<Framebuffer>) {
        let tiles = Tiles { frame: Arc::clone(frame), seen: Arc::new(Mutex::new(vec![SeenTile::default(); frame.tiles.len()])) };
        self.image(name, frame.size_of_picture(), &frame.all_channels()).frame = Some(tiles);
    }

    /// Some of the `channels` of an image, before its tiles come.
    pub fn coarse(&mut self, name: &str, channels: &[String], picture: Picture) {
        let image = self.image(name, picture.size.map(|s| s as u32), channels);
        (image.whole, image.is_whole_sent) = (Some(Arc::new(picture)), false);
    }

    /// All of an image in the end.
    pub fn end(&mut self, name: &str, picture: Picture) {
        let picture = Arc::new(picture);
        let image = self.image(name, picture.size.map(|s| s as u32), &picture.channels);
        (image.whole, image.is_whole_sent) = (Some(picture), false);
        let bytes = |i: &Image| i.whole.as_ref().map_or(0, |picture| size_of_val(&*picture.data));
        // First those that the viewer has.
        while self.0.len() > 1 && self.0.iter().map(bytes).sum::<usize>() > KEPT {
            let oldest = self.0.iter().position(|i| i.is_whole_sent).unwrap_or_default();
            self.0.remove(oldest.min(self.0.len() - 2));
        }
    }

    /// The viewer has nothing.
    pub fn forget_sent(&mut self) {
        for image in &mut self.0 {
            (image.is_created, image.is_whole_sent) = (false, false);
            if let Some(tiles) = &image.frame {
                tiles.seen.lock().unwrap_or_else(PoisonError::into_inner).fill(SeenTile::default());
            }
        }
    }

    /// What is to be sent, which from now on counts as sent.
    pub fn take_work(&mut self) -> Vec<Work> {
        let last = self.0.len().saturating_sub(1);
        let work = self.0.iter_mut().enumerate().map(|(i, image)| {
            let create = !std::mem::replace(&mut image.is_created, true);
            let whole = image.whole.clone().filter(|_| !image.is_whole_sent);
            image.is_whole_sent |= whole.is_some();
            let (name, channels) = (image.name.clone(), image.channels.clone());
            Work { name, size: image.size, channels, create, grab: create && i == last, whole, tiles: image.frame.clone() }
        });
        work.filter(|work| work.create || work.whole.is_some() || work.tiles.is_some()).collect()
    }
}

impl Work {
    /// Sends it packet by packet.
    ///
    /// # Errors
    /// The first of `send`.
    pub fn send<E>(&self, mut send: impl FnMut(&[u8]) -> Result<(), E>) -> Result<(), E> {
        let Self { name, size, channels, .. } = self;
        if self.create {
            send(&packet::create_image(name, self.grab, *size, channels))?;
        }
        if let Some(picture) = &self.whole {
            let channels = &picture.channels;
            let row = size[0] as usize * channels.len();
            // All of it at once, but for pictures of a size that viewers do not take.
            let rows = (LARGEST / 4 / row.max(1)).clamp(1, size[1].max(1) as usize);
            for (part, data) in picture.data.chunks(rows * row).enumerate() {
                let pixels = Pixels { at: [0, (part * rows) as u32], size: [size[0], (data.len() / row) as u32], data };
                send(&packet::update_image(name, channels, &pixels))?;
            }
        }
        if let Some(tiles) = &self.tiles {
            tiles.frame.changed(&mut tiles.seen.lock().unwrap_or_else(PoisonError::into_inner), |pixels| {
                send(&packet::update_image(name, channels, &pixels))
            })?;
        }
        Ok(())
    }
}
