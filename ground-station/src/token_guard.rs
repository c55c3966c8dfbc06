//! Slows down the guessing of the token.
//!
//! After a wrong token the next one from the same address is looked at no sooner than [`PAUSE`]
//! later, one after the other, the right one too: a guesser learns nothing sooner by guessing in
//! parallel, or by hanging up on an answer that does not come at once. Other addresses do not wait.
//! Each wrong token is a line on standard error. A page that is open needs no token.

use std::collections::BTreeMap;
use std::net::{IpAddr, Ipv6Addr};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use tokio::time::{Instant, sleep_until};

/// The time between a wrong token and the next one of the same address.
pub const PAUSE: Duration = Duration::from_secs(1);
/// The number of requests of one address that may wait for their turn.
const MAX_WAITING: usize = 8;
/// The number of addresses that are remembered.
const MAX_ADDRESSES: usize = 256;

/// What a request with a token is told.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TokenAnswer {
    /// The token is right.
    Right,
    /// The token is wrong.
    Wrong,
    /// Too many requests of this address wait; the token was not looked at.
    Busy,
}

/// The wrong tokens of one address.
#[derive(Debug, Default)]
struct Wrong {
    count: u64,
    /// When the next token is looked at.
    next: Option<Instant>,
}

/// An address; the lock is held by the request whose turn it is.
type Turn = Arc<tokio::sync::Mutex<Wrong>>;

/// The addresses from which wrong tokens came.
#[derive(Debug, Default)]
pub struct TokenGuard {
    addresses: Mutex<BTreeMap<IpAddr, Turn>>,
}

impl TokenGuard {
    /// Looks at a token, as soon as its address may be answered.
    pub async fn check(&self, address: IpAddr, is_right: impl FnOnce() -> bool) -> TokenAnswer {
        let address = network(address);
        let turn = self.turn(address);
        // The map, this request and those that wait hold the turn.
        if Arc::strong_count(&turn) > MAX_WAITING + 1 {
            return TokenAnswer::Busy;
        }
        let mut wrong = turn.lock().await;
        if let Some(next) = wrong.next {
            sleep_until(next).await;
        }
        if is_right() {
            *wrong = Wrong::default();
            return TokenAnswer::Right;
        }
        wrong.count += 1;
        wrong.next = Some(Instant::now() + PAUSE);
        eprintln!("uchain-ground: a wrong token from {address} ({} so far)", wrong.count);
        TokenAnswer::Wrong
    }

    fn turn(&self, address: IpAddr) -> Turn {
        let mut addresses = self.addresses.lock().unwrap_or_else(PoisonError::into_inner);
        if addresses.len() >= MAX_ADDRESSES && !addresses.contains_key(&address) {
            // Those that no request waits at, and that need not wait any longer.
            addresses.retain(|_, turn| {
                let is_over = |wrong: &Wrong| wrong.next.is_none_or(|next| next <= Instant::now());
                !turn.try_lock().is_ok_and(|wrong| is_over(&wrong))
            });
        }
        Arc::clone(addresses.entry(address).or_default())
    }
}

/// The address, or of an address of IPv6 the network, in which a machine may have any number of
/// addresses.
fn network(address: IpAddr) -> IpAddr {
    match address {
        IpAddr::V4(_) => address,
        IpAddr::V6(address) => match address.to_ipv4_mapped() {
            Some(address) => address.into(),
            None => {
                let [a, b, c, d, ..] = address.segments();
                Ipv6Addr::new(a, b, c, d, 0, 0, 0, 0).into()
            }
        },
    }
}

#[cfg(test)]
mod tests {
    use std::net::Ipv4Addr;

    use futures_util::future::join_all;

    use super::*;

    const HERE: IpAddr = IpAddr::V4(Ipv4Addr::LOCALHOST);
    const THERE: IpAddr = IpAddr::V4(Ipv4Addr::new(192, 168, 0, 7));

    #[tokio::test(start_paused = true)]
    async fn a_right_token_is_answered_at_once() {
        let (guard, began) = (TokenGuard::default(), Instant::now());
        for _ in 0..100 {
            assert_eq!(guard.check(HERE, || true).await, TokenAnswer::Right);
        }
        assert_eq!(began.elapsed(), Duration::ZERO);
    }

    #[tokio::test(start_paused = true)]
    async fn guesses_take_a_second_each_and_the_right_one_waits_like_the_others() {
        let (guard, began) = (TokenGuard::default(), Instant::now());
        for _ in 0..10 {
            assert_eq!(guard.check(HERE, || false).await, TokenAnswer::Wrong);
        }
        assert_eq!(began.elapsed(), 9 * PAUSE);
        assert_eq!(guard.check(HERE, || true).await, TokenAnswer::Right);
        assert!(began.elapsed() >= 10 * PAUSE);
        // From then on that address waits no more.
        assert_eq!(guard.check(HERE, || true).await, TokenAnswer::Right);
        assert!(began.elapsed() < 11 * PAUSE);
    }

    /// A guesser that hangs up at once, and asks many times at the same time.
    #[tokio::test(start_paused = true)]
    async fn guessing_in_parallel_is_no_faster() {
        let guard = TokenGuard::default();
        guard.check(HERE, || false).await;
        let looked_at = std::cell::Cell::new(0);
        let guess = || {
            looked_at.set(looked_at.get() + 1);
            false
        };
        for _ in 0..100 {
            let guesses = join_all((0..50).map(|_| guard.check(HERE, guess)));
            let _ = tokio::time::timeout(Duration::from_millis(100), guesses).await;
        }
        assert!(looked_at.get() <= 11, "{} guesses in 10 s", looked_at.get());
    }

    #[tokio::test(start_paused = true)]
    async fn wrong_tokens_of_one_address_hold_up_no_other() {
        let (guard, began) = (TokenGuard::default(), Instant::now());
        guard.check(THERE, || false).await;
        assert_eq!(guard.check(HERE, || true).await, TokenAnswer::Right);
        assert_eq!(began.elapsed(), Duration::ZERO);
        let neighbours = ["fd00::1", "fd00::2"].map(|text| network(text.parse().unwrap()));
        assert_eq!(neighbours[0], neighbours[1]);
    }

    #[tokio::test(start_paused = true)]
    async fn addresses_are_not_remembered_without_end() {
        let guard = TokenGuard::default();
        for n in 0..2_000_u16 {
            let [a, b] = n.to_be_bytes();
            guard.check(Ipv4Addr::new(10, 0, a, b).into(), || false).await;
            tokio::time::sleep(Duration::from_millis(10)).await;
        }
        let known = guard.addresses.lock().unwrap().len();
        assert!(known <= MAX_ADDRESSES, "{known}");
    }
}
