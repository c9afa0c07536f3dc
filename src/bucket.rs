//! A study's folder in an S3 object store: parts are made on the local disk and uploaded when complete.
//!
//! Address, region and keys come from the environment (`AWS_ENDPOINT_URL`, `AWS_REGION`, `AWS_ACCESS_KEY_ID`, …) or the machine,
//! as for Amazon's own programs.

use anyhow::{Context, bail};
use object_store::aws::{AmazonS3, AmazonS3Builder, AmazonS3ConfigKey};
use object_store::path::Path as Key;
use object_store::{Error, ObjectStore, ObjectStoreExt, RetryConfig, WriteMultipart};
use std::fs::File;
use std::io::{self, Read, Write};
use std::path::{Path, PathBuf};
use std::time::Duration;
use sweep::store::{LocalFile, Store};
use tempfile::{NamedTempFile, TempDir};
use tokio::runtime::Runtime;

/// Bytes per transfer.
const PIECE: usize = 8 << 20;
/// Number of parallel transfers of a file.
const ON_THE_WAY: usize = 4;
/// How long a request is retried: a wrong address is reported within this time.
const PATIENCE: Duration = Duration::from_secs(20);

/// A folder in a bucket.
pub struct Bucket {
    location: PathBuf,
    prefix: Key,
    store: AmazonS3,
    runtime: Runtime,
    /// Local folder in which files are made.
    staging: TempDir,
}

impl Bucket {
    /// Opens `s3://bucket/prefix`.
    ///
    /// # Errors
    /// The address is invalid, or there are no credentials.
    pub fn open(location: &Path) -> anyhow::Result<Self> {
        // Another library in this process may have chosen one already, which is also suitable.
        let _ = rustls::crypto::ring::default_provider().install_default();
        let url = location.to_str().unwrap_or_default();
        let path = url.strip_prefix("s3://").and_then(|rest| rest.split_once('/'));
        let prefix = path.map(|(_, prefix)| prefix).filter(|prefix| !prefix.is_empty());
        let prefix = prefix.with_context(|| format!("{url}: expected s3://bucket/prefix"))?;
        let plain = ["AWS_ENDPOINT_URL_S3", "AWS_ENDPOINT_URL", "AWS_ENDPOINT"];
        let plain =
            plain.iter().find_map(|name| std::env::var(name).ok()).is_some_and(|url| url.starts_with("http://"));
        let retry = RetryConfig { max_retries: 5, retry_timeout: PATIENCE, ..RetryConfig::default() };
        let builder = AmazonS3Builder::from_env().with_url(url).with_allow_http(plain).with_retry(retry);
        let is_signed = builder.get_config_value(&AmazonS3ConfigKey::SkipSignature).as_deref() != Some("true");
        let runtime = tokio::runtime::Builder::new_multi_thread().worker_threads(2).enable_all().build();
        let bucket = Self {
            location: location.to_owned(),
            prefix: Key::parse(prefix).with_context(|| url.to_owned())?,
            store: builder.build().map_err(io_error).with_context(|| url.to_owned())?,
            runtime: runtime.context("threads cannot be started")?,
            staging: tempfile::tempdir().context("a temporary folder cannot be made")?,
        };
        if is_signed && let Err(error) = bucket.runtime.block_on(bucket.store.credentials().get_credential()) {
            bail!(
                "{url}: no credentials were found: set AWS_ACCESS_KEY_ID and AWS_SECRET_ACCESS_KEY (this machine's own role was asked for too: {})",
                io_error(error)
            );
        }
        Ok(bucket)
    }

    fn key(&self, name: &str) -> Key {
        name.split('/').filter(|part| !part.is_empty()).fold(self.prefix.clone(), Key::join)
    }

    async fn send(&self, file: &mut File, name: &str) -> io::Result<()> {
        let mut piece = Vec::new();
        let length = file.metadata()?.len();
        if length <= PIECE as u64 {
            file.read_to_end(&mut piece)?;
            self.store.put(&self.key(name), piece.into()).await.map_err(io_error)?;
            return Ok(());
        }
        let upload = self.store.put_multipart(&self.key(name)).await.map_err(io_error)?;
        let mut upload = WriteMultipart::new_with_chunk_size(upload, PIECE);
        while Read::take(&mut *file, PIECE as u64).read_to_end(&mut piece)? > 0 {
            upload.wait_for_capacity(ON_THE_WAY).await.map_err(io_error)?;
            upload.write(&piece);
            piece.clear();
        }
        upload.finish().await.map(|_| ()).map_err(io_error)
    }
}

/// Converts the store's error to an I/O error with one line of text.
fn io_error(error: Error) -> io::Error {
    let kind = match &error {
        Error::NotFound { .. } => io::ErrorKind::NotFound,
        Error::PermissionDenied { .. } | Error::Unauthenticated { .. } => io::ErrorKind::PermissionDenied,
        _ => io::ErrorKind::Other,
    };
    io::Error::new(kind, error.to_string().split_whitespace().collect::<Vec<_>>().join(" "))
}

/// `None` if the object does not exist, instead of an error.
fn some<T>(result: Result<T, Error>) -> io::Result<Option<T>> {
    match result {
        Err(Error::NotFound { .. }) => Ok(None),
        other => other.map(Some).map_err(io_error),
    }
}

impl Store for Bucket {
    fn location(&self) -> &Path {
        &self.location
    }

    fn read(&self, name: &str) -> io::Result<Option<Vec<u8>>> {
        self.runtime.block_on(async {
            let Some(found) = some(self.store.get(&self.key(name)).await)? else { return Ok(None) };
            Ok(Some(found.bytes().await.map_err(io_error)?.to_vec()))
        })
    }

    fn length(&self, name: &str) -> io::Result<Option<u64>> {
        Ok(some(self.runtime.block_on(self.store.head(&self.key(name))))?.map(|found| found.size))
    }

    fn names(&self, folder: &str) -> io::Result<Vec<String>> {
        let found = self.runtime.block_on(self.store.list_with_delimiter(Some(&self.key(folder)))).map_err(io_error)?;
        let mut names: Vec<String> =
            found.objects.iter().filter_map(|object| object.location.filename().map(str::to_owned)).collect();
        names.sort();
        Ok(names)
    }

    fn local(&self, name: &str) -> io::Result<LocalFile> {
        let length = self.length(name)?.ok_or(io::ErrorKind::NotFound)?;
        let mut copy = NamedTempFile::new_in(self.staging.path())?;
        for begin in (0..length).step_by(PIECE) {
            let range = begin..length.min(begin + PIECE as u64);
            copy.write_all(&self.runtime.block_on(self.store.get_range(&self.key(name), range)).map_err(io_error)?)?;
        }
        Ok(LocalFile::Copy(copy.into_temp_path()))
    }

    fn write(&self, name: &str, bytes: &[u8]) -> io::Result<()> {
        let sent = self.runtime.block_on(self.store.put(&self.key(name), bytes.to_vec().into()));
        sent.map(|_| ()).map_err(io_error)
    }

    fn publish(&self, _: &File, path: &Path, name: &str) -> io::Result<()> {
        self.runtime.block_on(self.send(&mut File::open(path)?, name))
    }

    fn remove(&self, name: &str) -> io::Result<()> {
        some(self.runtime.block_on(self.store.delete(&self.key(name)))).map(|_| ())
    }

    fn staging(&self) -> io::Result<PathBuf> {
        Ok(self.staging.path().to_owned())
    }
}
