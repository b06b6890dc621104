//! The server: what can be asked for, and how long it runs.

use super::fields::Changes;
use super::guard::{self, LONGEST_BODY};
use super::message::Message;
use super::page;
use super::session::Session;
use super::slice::{self, Asked};
use crate::error::{Error, Result};
use axum::extract::{DefaultBodyLimit, Path, Query, State};
use axum::http::{StatusCode, header};
use axum::response::sse::{Event, KeepAlive, Sse};
use axum::response::{Html, IntoResponse, Response};
use axum::routing::{get, post};
use axum::{Json, Router, middleware};
use futures_util::stream::{self, Stream, StreamExt};
use serde_json::{Map, Value, json};
use std::convert::Infallible;
use std::net::{Ipv4Addr, TcpListener};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;
use tokio::sync::broadcast::Receiver;

/// How often the end is looked for.
const TICK: Duration = Duration::from_millis(50);

/// A place on this machine to serve at.
pub struct Served {
    listener: TcpListener,
    token: Arc<str>,
}

impl Served {
    /// Takes a port of this machine's own loop; 0 takes a free one.
    ///
    /// # Errors
    /// Where it is taken.
    pub fn at(port: u16) -> Result<Self> {
        let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, port)).and_then(|l| l.set_nonblocking(true).map(|()| l));
        let listener = listener.map_err(|e| {
            Error::usage(format!("cannot serve at port {port} of 127.0.0.1: {e}"))
                .help("leave --port out to take a free one")
        })?;
        Ok(Self { listener, token: guard::token().into() })
    }

    /// The address to open, with the token in it.
    ///
    /// # Errors
    /// Where the machine does not tell the port.
    pub fn address(&self) -> Result<String> {
        let address = self.listener.local_addr().map_err(|e| Error::failed(format!("cannot tell the port: {e}")))?;
        Ok(format!("http://{address}/{}/", self.token))
    }
}

/// Serves the session until `end` is true.
///
/// # Errors
/// Where the machine fails the server.
pub fn serve(served: Served, session: &Arc<Session>, end: &AtomicBool) -> Result<()> {
    let failed = |e: std::io::Error| Error::failed(format!("cannot serve: {e}"));
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().map_err(failed)?;
    let ran = runtime.block_on(async {
        let listener = tokio::net::TcpListener::from_std(served.listener)?;
        let server = axum::serve(listener, router(&served.token, session.clone()));
        let over = async {
            while !end.load(Ordering::SeqCst) {
                tokio::time::sleep(TICK).await;
            }
        };
        tokio::select! {
            ran = server.into_future() => ran,
            () = over => Ok(()),
        }
    });
    session.close();
    ran.map_err(failed)
}

fn router(token: &Arc<str>, session: Arc<Session>) -> Router {
    let at = |path: &str| format!("/{token}/{path}");
    Router::new()
        .route(&at(""), get(home))
        .route(&at("events"), get(events))
        .route(&at("change"), post(change))
        .route(&at("keep"), post(keep))
        .route(&at("correct"), post(correct))
        .route(&at("undo"), post(undo))
        .route(&at("slice"), get(sliced))
        .route(&at("overlay/{n}"), get(overlay))
        .layer(DefaultBodyLimit::max(LONGEST_BODY))
        .layer(middleware::from_fn_with_state(token.clone(), guard::guard))
        .with_state(session)
}

type Shared = State<Arc<Session>>;

/// An error as the page shows it.
struct Fault(Error);

impl IntoResponse for Fault {
    fn into_response(self) -> Response {
        let messages: Vec<String> = self
            .0
            .apart()
            .into_iter()
            .map(|e| e.message + &e.help.map(|h| format!(": {h}")).unwrap_or_default())
            .collect();
        (StatusCode::UNPROCESSABLE_ENTITY, Json(json!({ "error": messages.join("; ") }))).into_response()
    }
}

/// Runs what reads and computes beside the server.
async fn aside<T: Send + 'static>(work: impl FnOnce() -> Result<T> + Send + 'static) -> std::result::Result<T, Fault> {
    let ran = tokio::task::spawn_blocking(work).await;
    ran.unwrap_or_else(|e| Err(Error::failed(format!("a request failed: {e}")))).map_err(Fault)
}

async fn home(State(session): Shared) -> Response {
    let nonce = guard::token();
    let policy = page::policy(&nonce);
    ([(header::CONTENT_SECURITY_POLICY, policy)], Html(session.page(&nonce))).into_response()
}

/// What was told last, then everything as it comes. Who is too slow is cut off and connects anew.
async fn events(State(session): Shared) -> Sse<impl Stream<Item = std::result::Result<Event, Infallible>>> {
    let (last, receiver) = session.listen();
    let coming = stream::unfold(receiver, |mut receiver: Receiver<Message>| async move {
        receiver.recv().await.ok().map(|message| (message, receiver))
    });
    let event = |(about, text): Message| Ok(Event::default().event(about.name()).data(&*text));
    Sse::new(stream::iter(last).chain(coming).map(event)).keep_alive(KeepAlive::default())
}

async fn change(State(session): Shared, Json(changes): Json<Changes>) -> std::result::Result<Response, Fault> {
    let turn = session.ask(changes).map_err(Fault)?;
    Ok(Json(json!({ "turn": turn })).into_response())
}

async fn keep(State(session): Shared, Json(changes): Json<Changes>) -> std::result::Result<Response, Fault> {
    let turn = aside(move || session.keep(changes)).await?;
    Ok(Json(json!({ "turn": turn })).into_response())
}

async fn correct(
    State(session): Shared,
    Json(entry): Json<Map<String, Value>>,
) -> std::result::Result<Response, Fault> {
    let turn = aside(move || session.correct(entry)).await?;
    Ok(Json(json!({ "turn": turn })).into_response())
}

async fn undo(State(session): Shared) -> std::result::Result<Response, Fault> {
    let turn = aside(move || session.undo()).await?;
    Ok(Json(json!({ "turn": turn })).into_response())
}

async fn sliced(State(session): Shared, Query(asked): Query<Asked>) -> std::result::Result<Response, Fault> {
    Ok(Json(aside(move || slice::slice(&session, &asked)).await?).into_response())
}

/// A photograph with the root voxels on it, made when it is looked at.
async fn overlay(State(session): Shared, Path(n): Path<usize>) -> std::result::Result<Response, Fault> {
    let jpeg = aside(move || {
        let (study, machine) = session.shown()?;
        let overlays = &study.planned()?.1.shown()?.overlays;
        let node = *overlays.get(n).ok_or_else(|| Error::usage(format!("there is no photograph {n}")))?;
        machine.run(study.graph(), &[node], &Arc::default(), |_| {})?.artefact(node)?.bytes("overlay.jpg")
    });
    Ok(([(header::CONTENT_TYPE, "image/jpeg")], jpeg.await?).into_response())
}
