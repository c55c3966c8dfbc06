//! Serves the page, its WebSocket, and the live stream.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use axum::Router;
use axum::extract::ws::{Message, WebSocket, WebSocketUpgrade};
use axum::extract::{Query, Request, State};
use axum::http::{HeaderMap, StatusCode, header};
use axum::middleware::{self, Next};
use axum::response::{IntoResponse, Response};
use axum::routing::get;
use serde::Deserialize;

use crate::access::{Access, Refused};
use crate::foxglove;
use crate::station::{self, Handle};
use crate::steering::PageId;

const PAGE: &str = include_str!("page/index.html");
const SCRIPT: &str = include_str!("page/page.js");
const MAP: &str = include_str!("page/map.js");
const STYLE: &str = include_str!("page/page.css");

/// The place in the page where the session token goes.
const SESSION_MARK: &str = "{{session}}";

/// The longest request of a page in bytes; the longest order takes 60.
const MAX_REQUEST: usize = 1024;
/// The longest message of a viewer in bytes; a subscription of a channel takes some 40.
const MAX_SUBSCRIPTION: usize = 16 * 1024;

/// What the requests share.
#[derive(Debug)]
struct Shared {
    access: Access,
    station: Handle,
    pages: AtomicU64,
}

/// The tokens of a request.
#[derive(Deserialize)]
struct Tokens {
    token: Option<String>,
    session: Option<String>,
}

/// The routes of a station's server.
pub fn router(access: Access, station: Handle) -> Router {
    let shared = Arc::new(Shared { access, station, pages: AtomicU64::new(0) });
    Router::new()
        .route("/", get(page))
        .route("/page.js", get(|| async { file("text/javascript; charset=utf-8", SCRIPT) }))
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
        (StatusCode::FORBIDDEN, format!("{self}\n")).into_response()
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
    Query(tokens): Query<Tokens>,
) -> Result<Response, Refused> {
    shared.access.check_token(tokens.token.as_deref())?;
    Ok(file("text/html; charset=utf-8", PAGE.replace(SESSION_MARK, shared.access.session())))
}

async fn live(
    State(shared): State<Arc<Shared>>,
    Query(tokens): Query<Tokens>,
    upgrade: WebSocketUpgrade,
) -> Result<Response, Refused> {
    shared.access.check_session(tokens.session.as_deref())?;
    let page = PageId(shared.pages.fetch_add(1, Ordering::Relaxed) + 1);
    let station = shared.station.clone();
    Ok(upgrade.max_message_size(MAX_REQUEST).on_upgrade(move |socket| async move {
        attend(socket, page, &station).await;
        station.close(page).await;
    }))
}

/// Opens the live stream to a viewer that speaks Foxglove's protocol.
async fn view(
    State(shared): State<Arc<Shared>>,
    headers: HeaderMap,
    Query(tokens): Query<Tokens>,
    upgrade: WebSocketUpgrade,
) -> Result<Response, Refused> {
    let (host, origin) = named(&headers);
    shared.access.check_viewer(host, origin, tokens.token.as_deref())?;
    let upgrade = upgrade.protocols(foxglove::PROTOCOLS).max_message_size(MAX_SUBSCRIPTION);
    if upgrade.selected_protocol().is_none() {
        let wrong =
            format!("refused: this is a stream for {}\n", foxglove::PROTOCOLS.join(" and "));
        return Ok((StatusCode::BAD_REQUEST, wrong).into_response());
    }
    let station = shared.station.clone();
    Ok(upgrade.on_upgrade(move |socket| async move {
        foxglove::attend(socket, station.stream()).await;
    }))
}

/// Attends to a page until it is closed.
async fn attend(mut socket: WebSocket, page: PageId, station: &Handle) {
    let welcome = format!("{{\"page\":{},\"plan\":{}}}", page.0, station.plan());
    if socket.send(Message::Text(welcome.into())).await.is_err() {
        return;
    }
    let mut status = station.status();
    loop {
        tokio::select! {
            message = socket.recv() => match message {
                Some(Ok(Message::Text(text))) => {
                    // A message that is no request comes from no page of this station.
                    let Ok(request) = serde_json::from_str::<station::Request>(&text) else { return };
                    station.send(page, request).await;
                }
                Some(Ok(Message::Close(_)) | Err(_)) | None => return,
                Some(Ok(Message::Binary(_) | Message::Ping(_) | Message::Pong(_))) => {}
            },
            changed = status.changed() => {
                if changed.is_err() {
                    return;
                }
                let json = status.borrow_and_update().to_string();
                if socket.send(Message::Text(json.into())).await.is_err() {
                    return;
                }
            }
        }
    }
}
