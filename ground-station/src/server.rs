//! Routes requests to the page, to its WebSocket and to the live stream.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use axum::extract::ws::WebSocketUpgrade;
use axum::extract::{Query, Request, State};
use axum::http::{HeaderMap, StatusCode, header};
use axum::middleware::{self, Next};
use axum::response::{IntoResponse, Response};
use axum::routing::get;
use axum::{Extension, Router};
use serde::Deserialize;
use tokio::sync::Semaphore;

use crate::access::{Access, Refused};
use crate::foxglove;
use crate::listener::ClientAddress;
use crate::page_socket;
use crate::station::Handle;
use crate::steering::{LineId, PageId};
use crate::token_guard::{TokenAnswer, TokenGuard};

const PAGE: &str = include_str!("page/index.html");
const SCRIPT: &str = include_str!("page/page.js");
const GAMEPAD: &str = include_str!("page/gamepad.js");
const LINE: &str = include_str!("page/line.js");
const MAP: &str = include_str!("page/map.js");
const STRIP: &str = include_str!("page/strip.js");
const STYLE: &str = include_str!("page/page.css");

/// The place in the page where the session token goes.
const SESSION_MARK: &str = "{{session}}";

/// The longest request of a page in bytes; the longest order takes 120.
const MAX_REQUEST: usize = 1024;
/// The longest message of a viewer in bytes; a subscription of a channel takes some 40.
const MAX_SUBSCRIPTION: usize = 16 * 1024;

/// The number of sockets of pages that may be open, and the number of viewers. With the connections
/// that [wait](crate::listener::MAX_WAITING) they stay below the 256 files that some systems allow.
const MAX_PAGES: usize = 64;
const MAX_VIEWERS: usize = 16;

/// What the requests share.
#[derive(Debug)]
struct Shared {
    access: Access,
    guard: TokenGuard,
    station: Handle,
    /// The number of lines to pages that were opened.
    lines: AtomicU64,
    pages: Arc<Semaphore>,
    viewers: Arc<Semaphore>,
}

/// What stands behind the question mark of a request.
#[derive(Deserialize)]
struct Asked {
    token: Option<String>,
    session: Option<String>,
    /// The number of the page, which a page draws at random when it is loaded.
    page: Option<u64>,
    /// Whether the page comes back by itself, after it has lost its line.
    #[serde(default)]
    again: bool,
}

/// The routes of a station's server.
pub fn router(access: Access, station: Handle) -> Router {
    let shared = Arc::new(Shared {
        access,
        guard: TokenGuard::default(),
        station,
        lines: AtomicU64::new(0),
        pages: Arc::new(Semaphore::new(MAX_PAGES)),
        viewers: Arc::new(Semaphore::new(MAX_VIEWERS)),
    });
    Router::new()
        .route("/", get(page))
        .route("/page.js", get(|| async { file("text/javascript; charset=utf-8", SCRIPT) }))
        .route("/gamepad.js", get(|| async { file("text/javascript; charset=utf-8", GAMEPAD) }))
        .route("/line.js", get(|| async { file("text/javascript; charset=utf-8", LINE) }))
        .route("/strip.js", get(|| async { file("text/javascript; charset=utf-8", STRIP) }))
        .route("/map.js", get(|| async { file("text/javascript; charset=utf-8", MAP) }))
        .route("/page.css", get(|| async { file("text/css; charset=utf-8", STYLE) }))
        .route("/live", get(live))
        .layer(middleware::from_fn_with_state(Arc::clone(&shared), check_headers))
        // A viewer is a program, or a page of another site: it is checked by itself.
        .route("/foxglove", get(view))
        .with_state(shared)
}

impl IntoResponse for Refused {
    fn into_response(self) -> Response {
        let status = match self {
            Self::Busy => StatusCode::TOO_MANY_REQUESTS,
            Self::Full => StatusCode::SERVICE_UNAVAILABLE,
            Self::Host | Self::Origin | Self::Token | Self::Session => StatusCode::FORBIDDEN,
        };
        (status, format!("{self}\n")).into_response()
    }
}

impl Shared {
    /// Checks the token of a request, in its turn where wrong ones came from its address.
    async fn check_token(
        &self,
        ClientAddress(client): ClientAddress,
        given: Option<&str>,
    ) -> Result<(), Refused> {
        if !self.access.needs_token() {
            return Ok(());
        }
        match self.guard.check(client, || self.access.check_token(given).is_ok()).await {
            TokenAnswer::Right => Ok(()),
            TokenAnswer::Wrong => Err(Refused::Token),
            TokenAnswer::Busy => Err(Refused::Busy),
        }
    }
}

/// The host and the origin that a request names.
fn named(headers: &HeaderMap) -> (Option<&str>, Option<&str>) {
    let host = headers.get(header::HOST).and_then(|value| value.to_str().ok());
    // An origin that is no text is no origin of ours.
    let origin = headers.get(header::ORIGIN).map(|value| value.to_str().unwrap_or("unreadable"));
    (host, origin)
}

/// Refuses requests that do not come from the station's own page.
async fn check_headers(
    State(shared): State<Arc<Shared>>,
    headers: HeaderMap,
    request: Request,
    next: Next,
) -> Response {
    let (host, origin) = named(&headers);
    match shared.access.check_headers(host, origin) {
        Ok(()) => next.run(request).await,
        Err(refused) => refused.into_response(),
    }
}

fn file(kind: &'static str, text: impl IntoResponse) -> Response {
    let headers = [
        (header::CONTENT_TYPE, kind),
        (header::CACHE_CONTROL, "no-store"),
        // No script of others runs in the page, and no other page shows it in a frame.
        (header::CONTENT_SECURITY_POLICY, "default-src 'self'; frame-ancestors 'none'"),
        (header::REFERRER_POLICY, "no-referrer"),
    ];
    (headers, text).into_response()
}

async fn page(
    State(shared): State<Arc<Shared>>,
    Extension(client): Extension<ClientAddress>,
    Query(asked): Query<Asked>,
) -> Result<Response, Refused> {
    shared.check_token(client, asked.token.as_deref()).await?;
    Ok(file("text/html; charset=utf-8", PAGE.replace(SESSION_MARK, shared.access.session())))
}

async fn live(
    State(shared): State<Arc<Shared>>,
    Query(asked): Query<Asked>,
    upgrade: WebSocketUpgrade,
) -> Result<Response, Refused> {
    shared.access.check_session(asked.session.as_deref())?;
    let place = Arc::clone(&shared.pages).try_acquire_owned().map_err(|_| Refused::Full)?;
    let line = shared.lines.fetch_add(1, Ordering::Relaxed) + 1;
    let page = asked.page.map(PageId).filter(|page| *page != PageId::PROGRAM);
    let page = page.unwrap_or(PageId(line));
    let station = shared.station.clone();
    Ok(upgrade.max_message_size(MAX_REQUEST).on_upgrade(move |socket| async move {
        let line = LineId(line);
        station.open(line, page, !asked.again).await;
        page_socket::attend(socket, page, &station).await;
        station.close(line).await;
        drop(place);
    }))
}

/// Opens the live stream to a viewer that speaks Foxglove's protocol.
async fn view(
    State(shared): State<Arc<Shared>>,
    Extension(client): Extension<ClientAddress>,
    headers: HeaderMap,
    Query(asked): Query<Asked>,
    upgrade: WebSocketUpgrade,
) -> Result<Response, Refused> {
    let (host, origin) = named(&headers);
    shared.access.check_viewer(host, origin)?;
    shared.check_token(client, asked.token.as_deref()).await?;
    let place = Arc::clone(&shared.viewers).try_acquire_owned().map_err(|_| Refused::Full)?;
    let upgrade = upgrade.protocols(foxglove::PROTOCOLS).max_message_size(MAX_SUBSCRIPTION);
    if upgrade.selected_protocol().is_none() {
        let wrong =
            format!("refused: this is a stream for {}\n", foxglove::PROTOCOLS.join(" and "));
        return Ok((StatusCode::BAD_REQUEST, wrong).into_response());
    }
    let station = shared.station.clone();
    Ok(upgrade.on_upgrade(move |socket| async move {
        foxglove::attend(socket, station.stream()).await;
        drop(place);
    }))
}
