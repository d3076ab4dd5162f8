use super::*;

fn checked(path: &str, headers: &[(&'static str, &str)]) -> Result<(), RequestRefusal> {
    let mut map = HeaderMap::new();
    headers.iter().for_each(|(name, value)| {
        map.append(*name, HeaderValue::from_str(value).unwrap());
    });
    check_request(path, &map, "abc123", 8080)
}

#[test]
fn only_own_hosts_and_origins_pass() {
    let own = ("host", "127.0.0.1:8080");
    for host in ["127.0.0.1:8080", "localhost:8080", "LocalHost:8080", "[::1]:8080", "192.168.0.7:8080"] {
        assert_eq!(checked("/abc123/", &[("host", host)]), Ok(()), "{host}");
    }
    for host in ["evil.example:8080", "127.0.0.1", "127.0.0.1:80", "localhost.evil.example:8080", ""] {
        assert_eq!(checked("/abc123/", &[("host", host)]), Err(RequestRefusal::Host), "{host}");
    }
    assert_eq!(checked("/abc123/", &[]), Err(RequestRefusal::Host));
    assert_eq!(checked("/abc123/", &[own, ("host", "evil.example")]), Err(RequestRefusal::Host));
    assert_eq!(checked("/abc123/", &[own, ("origin", "http://127.0.0.1:8080")]), Ok(()));
    for origin in ["null", "https://127.0.0.1:8080", "http://evil.example", "http://127.0.0.1:8081"] {
        assert_eq!(checked("/abc123/", &[own, ("origin", origin)]), Err(RequestRefusal::Origin), "{origin}");
    }
    for path in ["/", "/abc124/", "/abc12/", "/abc1234/", "", "/events"] {
        assert_eq!(checked(path, &[own]), Err(RequestRefusal::Token), "{path}");
    }
}

/// Browsers leave the port out of `Host` and `Origin` if it is 80.
#[test]
fn hosts_without_port_mean_port_80() {
    let checked = |host: &str, port| {
        let mut map = HeaderMap::new();
        map.append("host", HeaderValue::from_str(host).unwrap());
        map.append("origin", HeaderValue::from_str(&format!("http://{host}")).unwrap());
        check_request("/abc123/", &map, "abc123", port)
    };
    for host in ["127.0.0.1", "localhost", "[::1]"] {
        assert_eq!((checked(host, 80), checked(host, 8080)), (Ok(()), Err(RequestRefusal::Host)), "{host}");
    }
    assert_eq!(checked("evil.example", 80), Err(RequestRefusal::Host));
}

#[test]
fn tokens_are_long_and_differ() {
    let [a, b] = [random_token().unwrap(), random_token().unwrap()];
    assert!(a.len() == 32 && a != b && a.bytes().all(|byte| byte.is_ascii_hexdigit()));
}
