//! The connection to a viewer, which may come, go, and stop reading whenever it likes.

use super::Address;
use std::io::{self, ErrorKind, Read, Write};
use std::net::{Shutdown, TcpStream};
use std::time::Duration;

/// Time that a host may take to answer, and a viewer to read on.
pub const PATIENCE: Duration = Duration::from_secs(3);

/// An open connection.
pub struct Connection(TcpStream);

impl Connection {
    /// Connects to whoever listens there.
    ///
    /// # Errors
    /// If nobody does.
    pub fn open(address: &Address) -> io::Result<Self> {
        let mut error = io::Error::from(ErrorKind::AddrNotAvailable);
        for address in address.resolve()? {
            match TcpStream::connect_timeout(&address, PATIENCE) {
                // Without a listener, a port out of those that the system gives away may connect with itself.
                Ok(stream) if stream.local_addr().ok() == stream.peer_addr().ok() => error = ErrorKind::ConnectionRefused.into(),
                Ok(stream) => {
                    stream.set_write_timeout(Some(PATIENCE))?;
                    stream.set_nodelay(true)?;
                    return Ok(Self(stream));
                }
                Err(why) => error = why,
            }
        }
        Err(error)
    }

    /// Sends a packet.
    ///
    /// # Errors
    /// If the viewer is gone, or has not read for [`PATIENCE`]: see [`has_stalled`]. Part of the packet may have been sent.
    pub fn send(&mut self, packet: &[u8]) -> io::Result<()> {
        self.0.write_all(packet)
    }

    /// Whether the viewer has closed it. What it says is read and dropped: unread, it would make the system drop what is on its way there.
    pub fn is_gone(&mut self) -> bool {
        if self.0.set_nonblocking(true).is_err() {
            return true;
        }
        let mut dropped = [0; 1024];
        let gone = loop {
            match self.0.read(&mut dropped) {
                Ok(0) => break true,
                Ok(_) => {}
                Err(error) if error.kind() == ErrorKind::Interrupted => {}
                Err(error) => break error.kind() != ErrorKind::WouldBlock,
            }
        };
        gone || self.0.set_nonblocking(false).is_err()
    }

    /// Sends what is on its way, and no more.
    pub fn close(self) {
        // It may be gone already.
        let _ = self.0.shutdown(Shutdown::Write);
    }
}

/// Whether sending failed because the viewer does not read.
pub fn has_stalled(error: &io::Error) -> bool {
    matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut)
}
