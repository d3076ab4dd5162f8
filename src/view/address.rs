//! Address at which the live page is served.

use std::net::{IpAddr, Ipv4Addr, SocketAddr};
use std::str::FromStr;

/// IP address and port at which the live page is served.
///
/// The default is the loopback address 127.0.0.1 with a free port, which only programs on this
/// machine can reach.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ListenAddress(pub SocketAddr);

impl Default for ListenAddress {
    fn default() -> Self {
        Self(SocketAddr::new(IpAddr::V4(Ipv4Addr::LOCALHOST), 0))
    }
}

/// Error: a text is not an address at which a server can listen.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("`{0}` is no address: write ADDR:PORT, such as 127.0.0.1:8080, or only a port")]
pub struct ListenAddressError(String);

impl FromStr for ListenAddress {
    type Err = ListenAddressError;

    /// Parses `ADDR:PORT`, or a port of the loopback address. `ADDR` is an IP address or
    /// `localhost`; port 0 selects a free port.
    fn from_str(text: &str) -> Result<Self, ListenAddressError> {
        if let Ok(port) = text.parse() {
            return Ok(Self(SocketAddr::new(IpAddr::V4(Ipv4Addr::LOCALHOST), port)));
        }
        let numeric = match text.strip_prefix("localhost:") {
            Some(port) => format!("{}:{port}", Ipv4Addr::LOCALHOST),
            None => text.to_owned(),
        };
        numeric.parse().map(Self).map_err(|_| ListenAddressError(text.to_owned()))
    }
}

/// Error: the page cannot be served at an address.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
#[error("cannot serve the live page at {address}: {source}")]
#[diagnostic(help("choose another address or port, or port 0 for a free one"))]
pub struct ListenError {
    /// The requested address.
    pub address: SocketAddr,
    /// Error of the operating system.
    pub source: std::io::Error,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn addresses_are_loopback_unless_named() {
        let parsed = |text: &str| text.parse::<ListenAddress>().map(|address| address.0.to_string());
        assert_eq!(parsed("8080").unwrap(), "127.0.0.1:8080");
        assert_eq!(parsed("localhost:0").unwrap(), "127.0.0.1:0");
        assert_eq!(parsed("[::1]:9000").unwrap(), "[::1]:9000");
        assert_eq!(parsed("0.0.0.0:1").unwrap(), "0.0.0.0:1");
        assert_eq!(ListenAddress::default().0.to_string(), "127.0.0.1:0");
        for wrong in ["scene.txt", "127.0.0.1", "70000", "evil.example:80", ""] {
            assert!(parsed(wrong).is_err(), "{wrong}");
        }
    }
}
