//! Protection of the web server against requests of other web sites.

use axum::http::header::{HOST, ORIGIN};
use axum::http::{HeaderMap, HeaderValue};
use std::net::IpAddr;

/// Port of an HTTP URL that has no port number.
const DEFAULT_HTTP_PORT: u16 = 80;

/// Number of random bytes of the secret token in the URL of a page.
const TOKEN_BYTES: usize = 16;

/// Reason why an HTTP request is refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum RequestRefusal {
    /// The path of the request does not begin with the secret token of the page.
    Token,
    /// The header `Host` does not hold an address of this server, or is missing.
    Host,
    /// The header `Origin` names another site: the request comes from a page of that site.
    Origin,
}

impl RequestRefusal {
    /// Returns the text of the response to the refused request.
    pub fn text(self) -> &'static str {
        match self {
            Self::Token => "the address lacks the token: open the address that caustica printed\n",
            Self::Host => "the header Host names no address of this server\n",
            Self::Origin => "the header Origin names another site\n",
        }
    }
}

/// Returns a token of 128 random bits from the operating system, in hexadecimal digits.
///
/// # Errors
/// An error of the operating system.
pub(super) fn random_token() -> std::io::Result<String> {
    let mut bytes = [0; TOKEN_BYTES];
    getrandom::fill(&mut bytes).map_err(std::io::Error::other)?;
    Ok(bytes.iter().map(|byte| format!("{byte:02x}")).collect())
}

/// Checks that a request comes from the page of the server at `port`, or from a user who opens that
/// page. Returns the reason for refusal otherwise.
///
/// Other sites cannot know the token, which is the first part of the path. A site whose name
/// resolves to this machine (DNS rebinding) sends its name in the header `Host`. So this header
/// must hold an IP address or `localhost`.
pub(super) fn check_request(path: &str, headers: &HeaderMap, token: &str, port: u16) -> Result<(), RequestRefusal> {
    let host = single_header(headers, HOST.as_str()).ok_or(RequestRefusal::Host)?;
    if !is_own_host(host, port) {
        return Err(RequestRefusal::Host);
    }
    if headers.contains_key(ORIGIN) {
        let origin = single_header(headers, ORIGIN.as_str()).and_then(|origin| origin.strip_prefix("http://"));
        if !origin.is_some_and(|origin| origin.eq_ignore_ascii_case(host)) {
            return Err(RequestRefusal::Origin);
        }
    }
    let first = path.trim_start_matches('/').split('/').next().unwrap_or("");
    if equal_in_constant_time(first.as_bytes(), token.as_bytes()) { Ok(()) } else { Err(RequestRefusal::Token) }
}

/// Returns the text of the header `name`; `None` unless the request has that header exactly once,
/// in ASCII.
fn single_header<'a>(headers: &'a HeaderMap, name: &str) -> Option<&'a str> {
    let mut values = headers.get_all(name).iter();
    let value: &HeaderValue = values.next()?;
    if values.next().is_some() { None } else { value.to_str().ok() }
}

/// True if `host` is an IP address or `localhost`, with the port of this server. Without a port,
/// `host` means port 80, the default of HTTP.
fn is_own_host(host: &str, port: u16) -> bool {
    // A colon inside brackets is part of an IPv6 address, and separates no port.
    let (name, number) = match host.rsplit_once(':') {
        Some((name, number)) if !number.ends_with(']') => (name, number.parse().ok()),
        Some(_) | None => (host, Some(DEFAULT_HTTP_PORT)),
    };
    let name = name.strip_prefix('[').and_then(|name| name.strip_suffix(']')).unwrap_or(name);
    number == Some(port) && (name.eq_ignore_ascii_case("localhost") || name.parse::<IpAddr>().is_ok())
}

/// True if both texts are equal. The time of the comparison does not reveal where they differ.
fn equal_in_constant_time(a: &[u8], b: &[u8]) -> bool {
    a.len() == b.len() && a.iter().zip(b).fold(0, |difference, (a, b)| difference | (a ^ b)) == 0
}

#[cfg(test)]
mod tests;
