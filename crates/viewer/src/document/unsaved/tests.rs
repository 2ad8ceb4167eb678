//! Versions of unsaved work, their offers, and their end.

use super::latest::{STROKE, hold};
use super::*;
use crate::document::painting::Painting;
use hypertexture::glam::Vec3;
use hypertexture::scene::Reach;
use std::thread;
use std::time::{Duration, Instant};

/// A window without a window: a model, an editor and a brush, whose work is kept in a folder.
struct Desk {
    model: Model,
    author: Author,
    painting: Painting,
    latest: Latest,
}

impl Desk {
    fn new(root: &Path) -> Desk {
        let library = shader::shipped();
        let author = Author::new("hypertexture".into(), &library, "dmf", "fur").unwrap();
        let model = Model::new(scene::preset("fur").unwrap(), library).unwrap();
        let latest = Latest::default();
        hold(&latest.0.kept).root = Some(root.into());
        Desk { model, author, painting: Painting::default(), latest }
    }

    fn keep(&self) -> Option<PathBuf> {
        self.latest.note(&self.model, &self.author, &self.painting);
        self.latest.keep()
    }
}

#[test]
fn one_version_is_kept_until_the_scene_is_saved() {
    let folder = tempfile::tempdir().unwrap();
    let root = folder.path().join("unsaved");
    let mut desk = Desk::new(&root);
    assert_eq!(desk.keep(), None, "nothing is unsaved");
    desk.model.edit("specular", |scene| scene.material.specular = 0.5);
    let first = desk.keep().unwrap();
    assert_eq!(desk.keep(), Some(first.clone()), "it has not changed");
    desk.model.edit("specular", |scene| scene.material.specular = 0.25);
    desk.author.text.push_str("// mine\n");
    let second = desk.keep().unwrap();
    assert!(!first.exists() && second.join("dmf/fur.glsl").exists());
    assert_eq!(scene::load(&second.join(SCENE), Reach::Anywhere).unwrap().material.specular, 0.25);
    assert_eq!(fs::read_dir(&root).unwrap().count(), 1);
    assert_eq!(kept_in(&root), Vec::<PathBuf>::new(), "its window is open");
    // A killed window drops its lock, and the work is offered.
    hold(&desk.latest.0.kept).lock = None;
    assert_eq!(kept_in(&root), std::slice::from_ref(&second));
    desk.author.reset();
    assert!(desk.model.save(&folder.path().join("own.toml")));
    assert_eq!(desk.keep(), None);
    assert!(kept_in(&root).is_empty() && !second.exists());
}

#[test]
fn the_work_is_on_disk_soon_after_a_change() {
    let folder = tempfile::tempdir().unwrap();
    let mut desk = Desk::new(folder.path());
    let keeper = desk.latest.watch();
    desk.model.edit("specular", |scene| scene.material.specular = 0.5);
    desk.latest.note(&desk.model, &desk.author, &desk.painting);
    let start = Instant::now();
    while fs::read_dir(folder.path()).unwrap().all(|entry| !entry.unwrap().path().join(SCENE).exists()) {
        assert!(start.elapsed() < Duration::from_secs(600)); // a test that fails ends
        thread::sleep(Duration::from_millis(10));
    }
    drop(keeper);
}

#[test]
fn a_stroke_that_goes_on_is_kept_with_its_groom() {
    let folder = tempfile::tempdir().unwrap();
    let mut desk = Desk::new(folder.path());
    let file = desk.painting.begin(desk.model.scene(), Vec3::X, Vec3::X).unwrap();
    assert!(desk.model.edit("groom", |scene| scene.groom = Some(file.clone())));
    assert_eq!(desk.keep(), None, "it has just begun");
    // The comb needs a motion.
    desk.painting.go(Vec3::new(1.0, 0.2, 0.0), Vec3::X);
    hold(&desk.latest.0.noted).stroke = Instant::now().checked_sub(STROKE);
    let kept = desk.keep().unwrap();
    assert!(!Path::new(&file).exists(), "its own file follows at its end");
    let scene = scene::load(&kept.join(SCENE), Reach::Anywhere).unwrap();
    let groom = Groom::read(Path::new(&scene.groom.unwrap())).unwrap();
    assert!((0..groom.voxels()).any(|index| groom.at(index) != Groom::NEUTRAL));
    desk.painting.cancel();
}

#[test]
fn restored_work_stays_that_of_its_file_and_unsaved() {
    let folder = tempfile::tempdir().unwrap();
    let (root, own) = (folder.path().join("unsaved"), folder.path().join("own.toml"));
    let mut desk = Desk::new(&root);
    assert!(desk.model.save(&own));
    desk.model.edit("specular", |scene| scene.material.specular = 0.5);
    let kept = desk.keep().unwrap();
    let mut next = Desk::new(&root);
    assert!(restore(&kept, &mut next.model, &mut next.author));
    assert_eq!((next.model.scene(), next.model.file()), (desk.model.scene(), Some(own.as_path())));
    assert!(next.model.is_dirty());
    next.latest.took(kept.clone());
    let again = next.keep().unwrap();
    assert!(kept.exists() && again.exists(), "until the end");
    next.latest.release();
    assert!(!kept.exists() && again.exists(), "it is offered once");
    assert!(next.model.save(&own) && !next.model.is_dirty());
}

#[test]
fn a_failed_store_of_work_is_tried_again() {
    let folder = tempfile::tempdir().unwrap();
    let root = folder.path().join("unsaved");
    let mut desk = Desk::new(&root);
    let old = folder.path().join("old");
    fs::create_dir_all(&old).unwrap();
    fs::write(old.join(SCENE), "").unwrap();
    desk.latest.took(old.clone());
    fs::write(&root, "no folder").unwrap();
    desk.model.edit("specular", |scene| scene.material.specular = 0.5);
    assert_eq!(desk.keep(), None);
    desk.latest.release();
    assert!(old.exists(), "there is no other version");
    fs::remove_file(&root).unwrap();
    assert!(desk.keep().is_some_and(|kept| kept.join(SCENE).exists()), "nothing has changed since");
}

#[test]
fn work_of_the_history_alone_is_offered_again() {
    let folder = tempfile::tempdir().unwrap();
    let root = folder.path().join("unsaved");
    let folders = ["first", "second", "third"].map(|name| folder.path().join(name));
    for own in &folders {
        fs::create_dir_all(own).unwrap();
        fs::write(own.join(SCENE), "").unwrap();
    }
    let mut desk = Desk::new(&root);
    // The first was saved when the second replaced it; the second was not when the third did.
    desk.latest.took(folders[0].clone());
    desk.latest.took(folders[1].clone());
    desk.model.edit("specular", |scene| scene.material.specular = 0.5);
    desk.keep();
    desk.latest.took(folders[2].clone());
    desk.latest.release();
    assert_eq!(folders.map(|own| own.exists()), [false, true, false]);
}

#[test]
fn work_that_cannot_be_restored_is_not_taken_over() {
    let folder = tempfile::tempdir().unwrap();
    let mut desk = Desk::new(&folder.path().join("unsaved"));
    let before = desk.model.scene().clone();
    fs::write(folder.path().join(SCENE), "[object]\ninput = 7\n").unwrap();
    assert!(!restore(folder.path(), &mut desk.model, &mut desk.author));
    assert!(desk.model.message().is_some() && desk.model.scene() == &before);
}

#[test]
fn a_stroke_that_has_just_begun_is_kept() {
    let folder = tempfile::tempdir().unwrap();
    let mut desk = Desk::new(folder.path());
    let file = desk.painting.begin(desk.model.scene(), Vec3::X, Vec3::X).unwrap();
    assert!(desk.model.edit("groom", |scene| scene.groom = Some(file)));
    assert_eq!(desk.keep(), None);
    desk.latest.note_last(&desk.model, &desk.author, &desk.painting);
    assert!(desk.latest.keep().is_some_and(|kept| kept.join(GROOM).exists()));
    desk.painting.cancel();
}
