//! Where a viewer listens.

use std::fmt;
use std::io;
use std::net::{SocketAddr, ToSocketAddrs};
use std::str::FromStr;

/// The port of tev and HDRView.
const PORT: u16 = 14158;
/// The host if none is named: this machine.
const HOST: &str = "127.0.0.1";

/// Host and port of a viewer.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Address {
    host: String,
    port: u16,
}

impl Address {
    /// Asks what its name stands for, which may take a while.
    ///
    /// # Errors
    /// If nobody knows it.
    pub fn resolve(&self) -> io::Result<impl Iterator<Item = SocketAddr> + use<>> {
        (self.host.as_str(), self.port).to_socket_addrs()
    }
}

impl Default for Address {
    fn default() -> Self {
        Self { host: HOST.to_owned(), port: PORT }
    }
}

impl fmt::Display for Address {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let Self { host, port } = self;
        if host.contains(':') { write!(f, "[{host}]:{port}") } else { write!(f, "{host}:{port}") }
    }
}

impl FromStr for Address {
    type Err = String;

    /// `HOST:PORT`, `HOST`, `:PORT`; addresses with colons stand in brackets, or alone.
    fn from_str(text: &str) -> Result<Self, String> {
        let expected = || "expected HOST:PORT, such as 127.0.0.1:14158 or [::1]:14158".to_owned();
        let (host, port) = match text.strip_prefix('[').map(|rest| rest.split_once(']')) {
            Some(inner) => {
                let (host, port) = inner.ok_or_else(expected)?;
                (host, if port.is_empty() { None } else { Some(port.strip_prefix(':').ok_or_else(expected)?) })
            }
            None if text.matches(':').count() > 1 => (text, None),
            None => text.split_once(':').map_or((text, None), |(host, port)| (host, Some(port))),
        };
        let port = port.map_or(Some(PORT), |port| port.parse().ok().filter(|port| *port > 0)).ok_or_else(expected)?;
        if text.is_empty() || host.contains(|c: char| c.is_whitespace() || c.is_control() || "/[]".contains(c)) {
            return Err(expected());
        }
        Ok(Self { host: if host.is_empty() { HOST } else { host }.to_owned(), port })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn addresses_are_read_as_people_write_them() {
        let cases = [
            ("127.0.0.1:14158", "127.0.0.1:14158"),
            ("studio", "studio:14158"),
            (":9000", "127.0.0.1:9000"),
            ("[::1]:9000", "[::1]:9000"),
            ("[::1]", "[::1]:14158"),
            ("::1", "[::1]:14158"),
        ];
        for (text, shown) in cases {
            assert_eq!(text.parse::<Address>().map(|a| a.to_string()), Ok(shown.to_owned()), "{text}");
        }
        for wrong in ["", "a:b", "host:0", "host:70000", "[::1", "[::1]9", "a b:1", "http://host:80", "host:"] {
            assert!(wrong.parse::<Address>().is_err(), "{wrong}");
        }
        assert_eq!(Address::default().to_string(), "127.0.0.1:14158");
    }
}
