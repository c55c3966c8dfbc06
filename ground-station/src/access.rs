//! Decides who may connect.
//!
//! A page of another site that is open in the same browser can send requests to this machine. It
//! cannot choose the headers `Host` and `Origin` and cannot read the station's page, so three
//! checks keep it out: the `Host` must be this machine, against a site whose name suddenly stands
//! for 127.0.0.1; the `Origin`, where the browser sends one, must be the station itself; and the
//! WebSocket is opened with a session token that stands in the page alone.

use std::fmt;
use std::net::IpAddr;

/// The secrets and the address of a station.
#[derive(Clone, Debug)]
pub struct Access {
    listens_at: IpAddr,
    /// The token that a person types who connects to another address than this machine's own.
    token: Option<String>,
    /// The token of this run, which stands in the page.
    session: String,
}

/// Why a station cannot be opened at an address, or a request is refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Refused {
    /// The `Host` header does not name this machine.
    Host,
    /// The request comes from a page of another site.
    Origin,
    /// The token is missing or wrong.
    Token,
    /// The session token is missing or wrong: the page is older than the station.
    Session,
    /// Too many requests wait because wrong tokens came from their address.
    Busy,
    /// As many pages or viewers are open as may be.
    Full,
}

impl fmt::Display for Refused {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Host => "refused: open the station by its address, http://127.0.0.1 and its port",
            Self::Origin => "refused: this request comes from a page of another site",
            Self::Token => "refused: add ?token= and the token of uchain-ground",
            Self::Session => "refused: the station was restarted; load the page anew",
            Self::Busy => "refused: wrong tokens came from this address; try again in some seconds",
            Self::Full => "refused: too many are open; close one",
        })
    }
}

impl Access {
    /// The number of random bytes of a session token.
    const SESSION_BYTES: usize = 16;

    /// The access of a station that listens at this address.
    ///
    /// # Errors
    /// [`Refused::Token`] where the address is not this machine's own and there is no token, and
    /// an error of the machine's random numbers.
    pub fn new(listens_at: IpAddr, token: Option<String>) -> Result<Self, Refused> {
        let token = token.filter(|token| !token.is_empty());
        if !listens_at.is_loopback() && token.is_none() {
            return Err(Refused::Token);
        }
        let mut bytes = [0_u8; Self::SESSION_BYTES];
        getrandom::fill(&mut bytes).map_err(|_| Refused::Session)?;
        let session = bytes.iter().map(|byte| format!("{byte:02x}")).collect();
        Ok(Self { listens_at, token, session })
    }

    /// Whether the page and the live stream need the token.
    #[must_use]
    pub const fn needs_token(&self) -> bool {
        self.token.is_some()
    }

    /// The token of this run, to be written into the page.
    #[must_use]
    pub fn session(&self) -> &str {
        &self.session
    }

    /// Checks the headers of any request.
    ///
    /// # Errors
    /// Which of the two headers is wrong.
    pub fn check_headers(&self, host: Option<&str>, origin: Option<&str>) -> Result<(), Refused> {
        let host = host.ok_or(Refused::Host)?;
        // At another address the machine may have any name: there the token keeps strangers out.
        if self.listens_at.is_loopback() && !is_loopback(host) {
            return Err(Refused::Host);
        }
        match origin {
            Some(origin) if origin != format!("http://{host}") => Err(Refused::Origin),
            _ => Ok(()),
        }
    }

    /// Checks the token with which the page was asked for.
    ///
    /// # Errors
    /// [`Refused::Token`] where it is needed, and missing or wrong.
    pub fn check_token(&self, given: Option<&str>) -> Result<(), Refused> {
        match &self.token {
            Some(token) if !given.is_some_and(|given| same(given, token)) => Err(Refused::Token),
            _ => Ok(()),
        }
    }

    /// Checks the headers of a viewer of the live stream: a program, or a page of another site that
    /// a person has given the token, which is checked as that of the page is. Without a token no page
    /// of another site may read.
    ///
    /// # Errors
    /// Which of the headers is wrong.
    pub fn check_viewer(&self, host: Option<&str>, origin: Option<&str>) -> Result<(), Refused> {
        match self.check_headers(host, origin) {
            Err(Refused::Origin) if self.token.is_some() => Ok(()),
            checked => checked,
        }
    }

    /// Checks the session token with which the WebSocket is opened.
    ///
    /// # Errors
    /// [`Refused::Session`] where it is missing or wrong.
    pub fn check_session(&self, given: Option<&str>) -> Result<(), Refused> {
        if given.is_some_and(|given| same(given, &self.session)) {
            Ok(())
        } else {
            Err(Refused::Session)
        }
    }
}

/// Whether a `Host` header names this machine by itself.
fn is_loopback(host: &str) -> bool {
    let name = match host.rsplit_once(':') {
        Some((name, port)) if port.bytes().all(|byte| byte.is_ascii_digit()) => name,
        _ => host,
    };
    let bare = name.trim_start_matches('[').trim_end_matches(']');
    name == "localhost" || bare.parse::<IpAddr>().is_ok_and(|address| address.is_loopback())
}

/// Compares two secrets in a time that does not tell where they differ.
fn same(given: &str, wanted: &str) -> bool {
    let (given, wanted) = (given.as_bytes(), wanted.as_bytes());
    given.len() == wanted.len()
        && given.iter().zip(wanted).fold(0, |differs, (a, b)| differs | (a ^ b)) == 0
}

#[cfg(test)]
mod tests {
    use std::net::Ipv4Addr;

    use super::*;

    fn local() -> Access {
        Access::new(Ipv4Addr::LOCALHOST.into(), None).unwrap()
    }

    #[test]
    fn another_address_than_this_machines_own_needs_a_token() {
        let all = Ipv4Addr::UNSPECIFIED.into();
        for token in [None, Some(String::new())] {
            assert_eq!(Access::new(all, token).unwrap_err(), Refused::Token);
        }
        let access = Access::new(all, Some("bats".to_owned())).unwrap();
        assert_eq!(access.check_token(Some("bats")), Ok(()));
        for wrong in [None, Some(""), Some("bat"), Some("cats")] {
            assert_eq!(access.check_token(wrong), Err(Refused::Token));
        }
    }

    #[test]
    fn only_this_machines_own_names_are_hosts() {
        for host in ["127.0.0.1:8430", "localhost:8430", "[::1]:8430", "localhost"] {
            assert_eq!(local().check_headers(Some(host), None), Ok(()), "{host}");
        }
        for host in ["evil.example:8430", "192.168.0.2:8430", "127.0.0.1.evil.example", ""] {
            assert_eq!(local().check_headers(Some(host), None), Err(Refused::Host), "{host}");
        }
        assert_eq!(local().check_headers(None, None), Err(Refused::Host));
    }

    #[test]
    fn a_page_of_another_site_is_refused() {
        let host = Some("127.0.0.1:8430");
        assert_eq!(local().check_headers(host, Some("http://127.0.0.1:8430")), Ok(()));
        for origin in
            ["http://evil.example", "http://127.0.0.1:8431", "null", "https://127.0.0.1:8430"]
        {
            assert_eq!(local().check_headers(host, Some(origin)), Err(Refused::Origin), "{origin}");
        }
    }

    #[test]
    fn a_viewer_of_another_site_needs_a_station_with_a_token() {
        let host = Some("127.0.0.1:8430");
        let site = Some("https://app.foxglove.dev");
        assert_eq!(local().check_viewer(host, None), Ok(()));
        assert_eq!(local().check_viewer(host, site), Err(Refused::Origin));
        let named = Some("evil.example:8430");
        assert_eq!(local().check_viewer(named, None), Err(Refused::Host));
        let access = Access::new(Ipv4Addr::LOCALHOST.into(), Some("bats".to_owned())).unwrap();
        assert!(access.needs_token() && !local().needs_token());
        for origin in [None, site] {
            assert_eq!(access.check_viewer(host, origin), Ok(()));
        }
        assert_eq!(access.check_viewer(named, site), Err(Refused::Host));
    }

    #[test]
    fn each_run_has_a_session_of_its_own() {
        let (one, two) = (local(), local());
        assert_eq!(one.session().len(), 2 * Access::SESSION_BYTES);
        assert_eq!(one.check_session(Some(one.session())), Ok(()));
        assert_eq!(one.check_session(Some(two.session())), Err(Refused::Session));
        assert_eq!(one.check_session(None), Err(Refused::Session));
    }
}
