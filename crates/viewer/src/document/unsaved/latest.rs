//! The newest unsaved work, and the thread that keeps it.

use super::{PART, SCENE, Unsaved, new_folder, remove, root, take_over};
use crate::document::author::Author;
use crate::document::model::Model;
use crate::document::painting::Painting;
use std::fs::File;
use std::path::PathBuf;
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError, TryLockError as Held};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

/// Time from a change to the next version on disk. Higher: more is lost. Lower: a drag writes many versions.
const DEBOUNCE: Duration = Duration::from_secs(2);
/// Longest time without a version of a stroke that goes on.
pub(super) const STROKE: Duration = Duration::from_secs(2);
/// Longest wait for another thread that holds the work, when the program fails.
const MAX_LOCK_WAIT: Duration = Duration::from_secs(2);

/// The newest unsaved work, shared with the thread that keeps it and with threads that exit the program.
#[derive(Clone, Default)]
pub(crate) struct Latest(pub(super) Arc<Shared>);

#[derive(Default)]
pub(super) struct Shared {
    pub(super) noted: Mutex<Noted>,
    /// Wakes the thread that keeps the work.
    changed: Condvar,
    pub(super) kept: Mutex<Kept>,
}

/// The unsaved work, and the module from which it was derived.
#[derive(Default)]
pub(super) struct Noted {
    module: [String; 2],
    unsaved: Unsaved,
    /// Ascending number of the version.
    number: u64,
    /// Last version of a stroke that goes on.
    pub(super) stroke: Option<Instant>,
    /// Whether the thread that keeps the work is to end.
    ends: bool,
}

/// The version on disk.
#[derive(Default)]
pub(super) struct Kept {
    /// The folder of all versions, in place of that in the cache.
    pub(super) root: Option<PathBuf>,
    number: u64,
    folder: Option<PathBuf>,
    pub(super) lock: Option<File>,
    /// Folders of earlier windows whose work this one has taken over.
    taken: Vec<PathBuf>,
}

pub(super) fn hold<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// A lock within [`MAX_LOCK_WAIT`]: the thread that fails may hold it.
fn hold_soon<T>(mutex: &Mutex<T>) -> Option<MutexGuard<'_, T>> {
    let start = Instant::now();
    loop {
        match mutex.try_lock() {
            Ok(guard) => return Some(guard),
            Err(Held::Poisoned(guard)) => return Some(guard.into_inner()),
            Err(Held::WouldBlock) if start.elapsed() > MAX_LOCK_WAIT => return None,
            Err(Held::WouldBlock) => thread::sleep(Duration::from_millis(5)),
        }
    }
}

impl Latest {
    /// Records changes. Called once per frame. A stroke that goes on is recorded from time to time.
    pub(crate) fn note(&self, model: &Model, author: &Author, painting: &Painting) {
        self.record(model, author, painting, false);
    }

    /// Records changes at the end of a window, also those of a stroke that goes on.
    pub(crate) fn note_last(&self, model: &Model, author: &Author, painting: &Painting) {
        self.record(model, author, painting, true);
    }

    fn record(&self, model: &Model, author: &Author, painting: &Painting, is_last: bool) {
        let mut noted = hold(&self.0.noted);
        let stroke = painting.stroke();
        let since = stroke.as_ref().map(|_| noted.stroke.unwrap_or_else(Instant::now));
        noted.stroke = since;
        let is_due = since.is_some_and(|since| is_last || since.elapsed() >= STROKE);
        if stroke.is_some() && !is_due {
            return;
        }
        let scene = model.is_dirty().then(|| model.shared_scene());
        let same_text = noted.module[1] == author.text && noted.module[0] == author.path();
        let same_scene = match (&noted.unsaved.scene, scene) {
            (Some(own), Some(scene)) => Arc::ptr_eq(own, scene) || own == scene,
            (own, scene) => own.is_none() && scene.is_none(),
        };
        let same = same_text && same_scene && noted.unsaved.groom.is_none();
        if !same || is_due {
            let unsaved = Unsaved { groom: stroke, ..Unsaved::of(model, author) };
            let (module, number) = ([author.path(), author.text.clone()], noted.number + 1);
            let stroke = since.map(|_| Instant::now());
            *noted = Noted { module, unsaved, number, stroke, ends: noted.ends };
            self.0.changed.notify_all();
        }
    }

    /// Starts the thread that keeps the work.
    pub(crate) fn watch(&self) -> Keeper {
        let latest = self.clone();
        let thread = thread::Builder::new().name("unsaved".into()).spawn(move || latest.run());
        if let Err(error) = &thread {
            log::warn!("unsaved work is kept at the end only: cannot start a thread: {error}");
        }
        Keeper { latest: self.clone(), thread: thread.ok() }
    }

    fn run(&self) {
        let mut done = 0;
        let mut noted = hold(&self.0.noted);
        while !noted.ends {
            if noted.number == done {
                noted = self.0.changed.wait(noted).unwrap_or_else(PoisonError::into_inner);
                continue;
            }
            let start = Instant::now();
            while !noted.ends && start.elapsed() < DEBOUNCE {
                let left = DEBOUNCE.saturating_sub(start.elapsed());
                noted = self.0.changed.wait_timeout(noted, left).unwrap_or_else(PoisonError::into_inner).0;
            }
            done = noted.number;
            drop(noted);
            self.keep();
            noted = hold(&self.0.noted);
        }
    }

    /// Writes the unsaved work to a new folder, removes the one before, and returns the folder of the newest version;
    /// `None` without one. On failure, the one before stays, and the next call tries again.
    pub(crate) fn keep(&self) -> Option<PathBuf> {
        let mut kept = hold_soon(&self.0.kept)?;
        let (unsaved, number) = {
            let noted = hold_soon(&self.0.noted)?;
            if kept.number == noted.number {
                return kept.folder.clone();
            }
            (noted.unsaved.clone(), noted.number)
        };
        let folder = new_folder(&kept.root.clone().or_else(root)?)?;
        match unsaved.keep_locked(&folder) {
            Ok(lock) => {
                let folder = lock.is_some().then_some(folder);
                let before = std::mem::replace(&mut kept.folder, folder);
                (kept.lock, kept.number) = (lock, number);
                before.iter().for_each(|before| remove(before));
                kept.folder.clone()
            }
            Err(error) => {
                remove(&folder.with_extension(PART));
                log::warn!("unsaved work is not kept: {error}");
                kept.folder.clone()
            }
        }
    }

    /// Removes the version on disk, at the end of a window whose work nobody needs.
    pub(crate) fn discard(&self) {
        let mut kept = hold(&self.0.kept);
        kept.lock = None;
        kept.folder.take().iter().for_each(|folder| remove(folder));
    }

    /// Ends the offers of restored work, at the end of a window that has kept it or whose user has saved it. If the
    /// newest work could not be kept, the restored one is offered again.
    pub(crate) fn release(&self) {
        let mut kept = hold(&self.0.kept);
        if kept.number != hold(&self.0.noted).number {
            return;
        }
        let is_kept = kept.folder.is_some();
        let all = std::mem::take(&mut kept.taken);
        all.iter().filter(|taken| is_kept || taken.join(SCENE).exists()).for_each(|taken| take_over(taken));
    }

    /// Notes that the work in a folder was restored: it is offered no more once this window has ended. Work that it has
    /// replaced before it was saved is offered again.
    pub(crate) fn took(&self, folder: PathBuf) {
        let is_saved = hold(&self.0.noted).unsaved.is_empty();
        let mut kept = hold(&self.0.kept);
        if !is_saved {
            kept.taken.pop();
        }
        kept.taken.push(folder);
    }
}

/// The thread that keeps the work; dropping it ends the thread.
pub(crate) struct Keeper {
    latest: Latest,
    thread: Option<JoinHandle<()>>,
}

impl Drop for Keeper {
    fn drop(&mut self) {
        hold(&self.latest.0.noted).ends = true;
        self.latest.0.changed.notify_all();
        if let Some(thread) = self.thread.take()
            && thread.join().is_err()
        {
            log::error!("the thread that keeps unsaved work has failed");
        }
    }
}
