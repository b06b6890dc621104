//! Who is served: those who know the token, at an address of this machine, from a page of this server.
//!
//! - `Host` must be a name of this machine's own loop: a foreign name that was made to point here (DNS rebinding) is refused. Any port
//!   does, for an ssh tunnel has its own.
//! - `Origin`, which browsers send with what changes something, must be the server itself.
//! - The first part of the path must be the token; two are compared in a time that tells nothing of them.
//! - A body that says it is longer than any the page sends is refused unread; one that does not say is cut off there.

use axum::body::Body;
use axum::extract::{Request, State};
use axum::http::{HeaderMap, HeaderName, HeaderValue, StatusCode, header};
use axum::middleware::Next;
use axum::response::{IntoResponse, Response};
use std::sync::Arc;

/// The longest body, bytes.
pub const LONGEST_BODY: usize = 64 << 10;

/// Names of this machine's own loop.
const OWN_NAMES: [&str; 3] = ["127.0.0.1", "localhost", "[::1]"];

/// A token that cannot be guessed: 256 random bits, in hexadecimal.
pub fn token() -> String {
    format!("{:032x}{:032x}", rand::random::<u128>(), rand::random::<u128>())
}

/// Why a request is refused.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Refusal {
    Host,
    Origin,
    Token,
    Body,
}

impl Refusal {
    fn response(self) -> Response {
        let (status, text) = match self {
            Self::Host => (StatusCode::FORBIDDEN, "this server is reached as 127.0.0.1 or localhost only"),
            Self::Origin => (StatusCode::FORBIDDEN, "another page asked for this: refused"),
            Self::Token => (StatusCode::FORBIDDEN, "open the address that `rootvox view` printed: it holds the token"),
            Self::Body => (StatusCode::PAYLOAD_TOO_LARGE, "the body is too long"),
        };
        (status, text).into_response()
    }
}

/// Whether a request with this path and these headers is served.
pub fn check(token: &str, path: &str, headers: &HeaderMap) -> Result<(), Refusal> {
    let text = |name: HeaderName| headers.get_all(name).iter().map(|v| v.to_str().unwrap_or("?")).collect::<Vec<_>>();
    let hosts = text(header::HOST);
    let [host] = hosts[..] else { return Err(Refusal::Host) };
    let name = host.rsplit_once(':').filter(|(_, port)| port.parse::<u16>().is_ok()).map_or(host, |(name, _)| name);
    if !OWN_NAMES.contains(&name) {
        return Err(Refusal::Host);
    }
    if text(header::ORIGIN).iter().any(|origin| origin.strip_prefix("http://") != Some(host)) {
        return Err(Refusal::Origin);
    }
    let given = path.trim_start_matches('/').split('/').next().unwrap_or_default();
    // Hashes compare in constant time.
    if blake3::hash(given.as_bytes()) != blake3::hash(token.as_bytes()) {
        return Err(Refusal::Token);
    }
    let length = headers.get(header::CONTENT_LENGTH).and_then(|v| v.to_str().ok()?.parse::<u64>().ok());
    if length.is_some_and(|length| length > LONGEST_BODY as u64) {
        return Err(Refusal::Body);
    }
    Ok(())
}

/// Lets through what [`check`] allows, and forbids browsers what no answer needs.
pub async fn guard(State(token): State<Arc<str>>, request: Request<Body>, next: Next) -> Response {
    let mut response = match check(&token, request.uri().path(), request.headers()) {
        Ok(()) => next.run(request).await,
        Err(refusal) => refusal.response(),
    };
    for (name, value) in [
        ("x-content-type-options", "nosniff"),
        ("referrer-policy", "no-referrer"),
        ("cache-control", "no-store"),
        ("cross-origin-resource-policy", "same-origin"),
        ("cross-origin-opener-policy", "same-origin"),
        ("x-frame-options", "DENY"),
    ] {
        response.headers_mut().insert(HeaderName::from_static(name), HeaderValue::from_static(value));
    }
    response
        .headers_mut()
        .entry(header::CONTENT_SECURITY_POLICY)
        .or_insert(HeaderValue::from_static("default-src 'none'"));
    response
}

#[cfg(test)]
mod tests {
    use super::*;

    fn checked(path: &str, given: &[(HeaderName, &str)]) -> Result<(), Refusal> {
        let mut headers = HeaderMap::new();
        for (name, value) in given {
            headers.append(name, value.parse().unwrap());
        }
        check("c0ffee", path, &headers)
    }

    #[test]
    fn tokens_are_long_and_never_the_same() {
        assert_eq!(token().len(), 64);
        assert_ne!(token(), token());
    }

    #[test]
    fn only_own_names_own_pages_and_the_token_are_served() {
        let own = (header::HOST, "127.0.0.1:8000");
        assert_eq!(checked("/c0ffee/", std::slice::from_ref(&own)), Ok(()));
        assert_eq!(checked("/c0ffee/keep", &[own.clone(), (header::ORIGIN, "http://127.0.0.1:8000")]), Ok(()));
        for name in ["localhost:9000", "[::1]:9000", "localhost"] {
            assert_eq!(checked("/c0ffee/", &[(header::HOST, name)]), Ok(()), "{name}");
        }
        for name in ["evil.example:8000", "127.0.0.1.evil.example", "localhost.evil:8000", "127.0.0.1:80:80", ""] {
            assert_eq!(checked("/c0ffee/", &[(header::HOST, name)]), Err(Refusal::Host), "{name}");
        }
        assert_eq!(checked("/c0ffee/", &[]), Err(Refusal::Host));
        assert_eq!(checked("/c0ffee/", &[own.clone(), (header::HOST, "evil.example")]), Err(Refusal::Host));
        for origin in
            ["http://evil.example", "null", "https://127.0.0.1:8000", "http://127.0.0.1:8001", "http://localhost:8000"]
        {
            assert_eq!(checked("/c0ffee/", &[own.clone(), (header::ORIGIN, origin)]), Err(Refusal::Origin), "{origin}");
        }
        for path in ["/", "/c0ffe/", "/C0FFEE/", "/keep", "/../c0ffee/"] {
            assert_eq!(checked(path, std::slice::from_ref(&own)), Err(Refusal::Token), "{path}");
        }
        assert_eq!(checked("/c0ffee/keep", &[own, (header::CONTENT_LENGTH, "1000000000")]), Err(Refusal::Body));
    }
}
