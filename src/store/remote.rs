//! A store of packed nodes that is no folder of this machine's own: a web server, S3, or a folder as these hold it.
//!
//! It is read through: what comes is unpacked into a private folder, verified, and published like a result of our own.
//! Nothing that happens there fails a run: what cannot be had is computed, and a complaint tells why. Objects are
//! immutable; whoever pushes second finds the object there.

use std::io::{BufReader, Read};
use std::path::Path;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use bytes::Bytes;
use futures_util::StreamExt;
use object_store::aws::AmazonS3Builder;
use object_store::http::HttpBuilder;
use object_store::local::LocalFileSystem;
use object_store::path::Path as Place;
use object_store::{
    BackoffConfig, ClientOptions, ObjectStore, ObjectStoreExt, PutMode, PutOptions, PutPayload, RetryConfig,
    WriteMultipart,
};
use tokio::runtime::Runtime;

use super::digest::Key;
use super::manifest::Manifest;
use super::object;
use crate::error::{Error, Result};

/// Folder of the packed nodes.
pub(super) const FOLDER: &str = "packed-v1";

/// Nothing heard for so long ends a transfer.
const SILENCE: Duration = Duration::from_secs(30);

/// Objects above this size are pushed in parts of it, bytes.
const PART_BYTES: u64 = 16 << 20;

/// What became of a push.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Pushed {
    /// The object was there.
    There,
    /// It was sent, so many bytes.
    Sent(u64),
}

/// A store of packed nodes.
pub(super) struct Remote {
    name: String,
    objects: Arc<dyn ObjectStore>,
    prefix: Place,
    runtime: Runtime,
    state: Mutex<State>,
}

#[derive(Default)]
struct State {
    complaints: Vec<String>,
    /// Nothing is asked of it any more.
    is_down: bool,
}

impl Remote {
    /// Opens `https://…`, `http://…`, `s3://bucket/prefix` or a folder; nothing is asked of it yet.
    ///
    /// # Errors
    /// Where the address cannot be used.
    pub(super) fn open(name: &str) -> Result<Self> {
        let bad = |e: &dyn std::fmt::Display| {
            Error::usage(format!("cannot use the store `{name}`: {e}"))
                .help("name a folder, https://HOST/PATH or s3://BUCKET/PREFIX with the usual AWS_ variables set")
        };
        // Another part of the program may have chosen; that is as good.
        let _ = rustls::crypto::ring::default_provider().install_default();
        let client = ClientOptions::new()
            .with_timeout_disabled()
            .with_connect_timeout(Duration::from_secs(10))
            .with_allow_http(name.starts_with("http://"));
        let backoff = BackoffConfig { init_backoff: Duration::from_millis(100), ..BackoffConfig::default() };
        let retry = RetryConfig { backoff, max_retries: 2, retry_timeout: SILENCE };
        let (objects, prefix): (Arc<dyn ObjectStore>, &str) = if let Some(rest) = name.strip_prefix("s3://") {
            let (bucket, prefix) = rest.split_once('/').unwrap_or((rest, ""));
            let endpoint = ["AWS_ENDPOINT_URL_S3", "AWS_ENDPOINT_URL", "AWS_ENDPOINT"]
                .iter()
                .find_map(|variable| std::env::var(variable).ok());
            let is_plain = endpoint.is_some_and(|endpoint| endpoint.starts_with("http://"));
            let s3 = AmazonS3Builder::from_env()
                .with_bucket_name(bucket)
                .with_client_options(client.with_allow_http(is_plain))
                .with_retry(retry);
            (Arc::new(s3.build().map_err(|e| bad(&e))?), prefix)
        } else if name.starts_with("http://") || name.starts_with("https://") {
            let http = HttpBuilder::new().with_url(name).with_client_options(client).with_retry(retry);
            (Arc::new(http.build().map_err(|e| bad(&e))?), "")
        } else {
            (Arc::new(LocalFileSystem::new_with_prefix(name).map_err(|e| bad(&e))?), "")
        };
        let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().map_err(|e| bad(&e))?;
        let prefix = Place::parse(prefix).map_err(|e| bad(&e))?;
        Ok(Self { name: name.to_owned(), objects, prefix, runtime, state: Mutex::default() })
    }

    fn place(&self, stage: &str, key: Key) -> Place {
        self.prefix.clone().join(FOLDER).join(stage).join(format!("{key}.tar"))
    }

    /// What was noticed since the last time.
    pub(super) fn complaints(&self) -> Vec<String> {
        std::mem::take(&mut self.state.lock().unwrap_or_else(PoisonError::into_inner).complaints)
    }

    fn complain(&self, text: String, is_down: bool) {
        let mut state = self.state.lock().unwrap_or_else(PoisonError::into_inner);
        if !state.is_down && !state.complaints.contains(&text) {
            state.complaints.push(text);
        }
        state.is_down |= is_down;
    }

    /// The object of a node and its size; `None` where there is none, or it cannot be had.
    fn get(&self, stage: &str, key: Key) -> Option<(impl Read + '_, u64)> {
        if self.state.lock().unwrap_or_else(PoisonError::into_inner).is_down {
            return None;
        }
        let place = self.place(stage, key);
        let asked = self.runtime.block_on(async { tokio::time::timeout(SILENCE, self.objects.get(&place)).await });
        match asked {
            Ok(Ok(found)) => {
                let bytes = found.meta.size;
                let stream = found.into_stream();
                Some((
                    BufReader::with_capacity(1 << 16, Body { runtime: &self.runtime, stream, rest: Bytes::new() }),
                    bytes,
                ))
            }
            Ok(Err(object_store::Error::NotFound { source, .. })) if !source.to_string().contains("NoSuchBucket") => {
                None
            }
            Ok(Err(e)) => {
                self.give_up(&e);
                None
            }
            Err(_) => {
                self.complain(format!("`{}` does not answer: what it has is computed here", self.name), true);
                None
            }
        }
    }

    fn give_up(&self, cause: &object_store::Error) {
        use object_store::Error::{PermissionDenied, Unauthenticated};
        let text = match cause {
            PermissionDenied { .. } | Unauthenticated { .. } => {
                format!("`{}` refuses our credentials: what it has is computed here", self.name)
            }
            other => format!("`{}` cannot be read: what it has is computed here ({})", self.name, first_line(other)),
        };
        self.complain(text, true);
    }

    /// The manifest of a node.
    pub(super) fn manifest(&self, stage: &str, key: Key) -> Option<Manifest> {
        let (object, bytes) = self.get(stage, key)?;
        self.sound(stage, key, object::manifest(object, bytes, stage, key))
    }

    /// Unpacks a node into the empty `folder`; `None` where it cannot be had or is not what it should be.
    pub(super) fn fetch(&self, stage: &str, key: Key, folder: &Path) -> Option<Manifest> {
        let (object, bytes) = self.get(stage, key)?;
        self.sound(stage, key, object::unpack(object, bytes, stage, key, folder))
    }

    fn sound(&self, stage: &str, key: Key, found: Result<Manifest>) -> Option<Manifest> {
        let complain = |e: &Error| {
            let object = format!("{stage}/{key}.tar");
            self.complain(format!("`{object}` of `{}` is not used: {e}; it is computed here", self.name), false);
        };
        found.inspect_err(complain).ok()
    }

    /// Pushes the node in `folder`, unless it is there.
    ///
    /// # Errors
    /// Where the store cannot be written.
    pub(super) fn push(&self, stage: &str, key: Key, folder: &Path) -> Result<Pushed> {
        let place = self.place(stage, key);
        let cannot = |e: object_store::Error| {
            use object_store::Error::{NotImplemented, NotSupported, PermissionDenied, Unauthenticated};
            let help = match e {
                PermissionDenied { .. } | Unauthenticated { .. } => {
                    "check the AWS_ variables and the rights of their user"
                }
                NotImplemented { .. } | NotSupported { .. } => "push to s3://BUCKET/PREFIX or into a folder",
                _ => "push again: what is there already is not sent twice",
            };
            Error::failed(format!("cannot push to `{}`: {}", self.name, first_line(&e))).help(help)
        };
        if self.name.starts_with("http://") || self.name.starts_with("https://") {
            return Err(Error::usage(format!("`{}` can only be read", self.name))
                .help("push to s3://BUCKET/PREFIX or into the folder that the web server shows"));
        }
        match self.runtime.block_on(self.objects.head(&place)) {
            Ok(_) => return Ok(Pushed::There),
            Err(object_store::Error::NotFound { .. }) => {}
            Err(e) => return Err(cannot(e)),
        }
        let mut packed = tempfile::tempfile().map_err(|e| Error::io("write", &std::env::temp_dir(), e))?;
        object::pack(folder, &mut packed)?;
        let read = |e: std::io::Error| Error::io("read", folder, e);
        let bytes = packed.metadata().map_err(read)?.len();
        std::io::Seek::rewind(&mut packed).map_err(read)?;
        let sent = if bytes <= PART_BYTES {
            let mut all = Vec::new();
            packed.read_to_end(&mut all).map_err(read)?;
            let create = PutOptions { mode: PutMode::Create, ..PutOptions::default() };
            let payload = PutPayload::from(all);
            self.runtime.block_on(async {
                match self.objects.put_opts(&place, payload.clone(), create).await {
                    // A server that knows no conditions: the object is the same whoever writes it.
                    Err(object_store::Error::NotImplemented { .. } | object_store::Error::NotSupported { .. }) => {
                        self.objects.put(&place, payload).await.map(drop)
                    }
                    other => other.map(drop),
                }
            })
        } else {
            self.runtime.block_on(async {
                let upload = self.objects.put_multipart(&place).await?;
                let mut writer = WriteMultipart::new_with_chunk_size(upload, PART_BYTES as usize);
                let mut part = vec![0; 1 << 20];
                loop {
                    match packed.read(&mut part) {
                        Ok(0) => return writer.finish().await.map(drop),
                        Ok(n) => {
                            writer.wait_for_capacity(2).await?;
                            writer.write(&part[..n]);
                        }
                        Err(e) => {
                            writer.abort().await?;
                            return Err(object_store::Error::Generic { store: "packing", source: e.into() });
                        }
                    }
                }
            })
        };
        match sent {
            Ok(()) => Ok(Pushed::Sent(bytes)),
            Err(object_store::Error::AlreadyExists { .. } | object_store::Error::Precondition { .. }) => {
                Ok(Pushed::There)
            }
            Err(e) => Err(cannot(e)),
        }
    }
}

/// The cause in a line: some servers answer with a page.
fn first_line(cause: &object_store::Error) -> String {
    let text = cause.to_string();
    let line = text.lines().next().unwrap_or_default();
    line.chars().take(300).collect()
}

/// The bytes of an object as they come.
struct Body<'a> {
    runtime: &'a Runtime,
    stream: futures_util::stream::BoxStream<'static, object_store::Result<Bytes>>,
    rest: Bytes,
}

impl Read for Body<'_> {
    fn read(&mut self, to: &mut [u8]) -> std::io::Result<usize> {
        while self.rest.is_empty() {
            let next = async { tokio::time::timeout(SILENCE, self.stream.next()).await };
            match self.runtime.block_on(next) {
                Ok(Some(Ok(bytes))) => self.rest = bytes,
                Ok(Some(Err(e))) => return Err(std::io::Error::other(first_line(&e))),
                Ok(None) => return Ok(0),
                Err(_) => return Err(std::io::Error::other("the server fell silent")),
            }
        }
        let n = to.len().min(self.rest.len());
        to[..n].copy_from_slice(&self.rest.split_to(n));
        Ok(n)
    }
}
