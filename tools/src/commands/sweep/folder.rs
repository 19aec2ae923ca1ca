//! A sweep's folder: manifest, records and pictures, each file whole or not there.

use super::record::{Effects, Manifest, Outcome, Record, VERSION};
use crate::failure::Failure;
use crate::library;
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::path::{Path, PathBuf};

const MANIFEST: &str = "sweep.json";
const EFFECTS: &str = "effects.json";
const RECORDS: &str = "records";
const PICTURES: &str = "pictures";

/// A picture of a sweep.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Picture {
    /// The reference's.
    Reference,
    /// Of the setting at that place.
    Of(usize),
    /// Its difference to the reference.
    Difference(usize),
}

/// The folder.
pub struct Folder {
    path: PathBuf,
}

impl Folder {
    /// Begins a sweep, or goes on with one whose manifest is the same.
    ///
    /// # Errors
    /// [`Failure::Usage`] where another sweep is there, or the same one and `go_on` is false.
    pub fn begin(path: &Path, manifest: &Manifest, go_on: bool) -> Result<Self, Failure> {
        for part in [RECORDS, PICTURES] {
            let part = path.join(part);
            std::fs::create_dir_all(&part).map_err(|error| Failure::from(macula::Error::io(part, error)))?;
        }
        let folder = Self { path: path.to_owned() };
        if !path.join(MANIFEST).exists() {
            folder.store(MANIFEST, manifest)?;
            return Ok(folder);
        }
        let there = folder.manifest()?;
        let differs = there.difference(manifest);
        if let Some(what) = differs {
            return Err(Failure::usage(format!(
                "{}: holds a sweep with {what}; write to another folder, or give that sweep's options",
                path.display()
            )));
        }
        if !go_on {
            return Err(Failure::usage(format!(
                "{}: holds this sweep already; add --resume to go on with it, or write to another folder",
                path.display()
            )));
        }
        Ok(folder)
    }

    /// Opens a sweep.
    ///
    /// # Errors
    /// A folder that holds none.
    pub fn open(path: &Path) -> Result<(Self, Manifest), Failure> {
        let folder = Self { path: path.to_owned() };
        let manifest = folder.manifest()?;
        Ok((folder, manifest))
    }

    /// A file in it.
    pub fn file(&self, name: &str) -> PathBuf {
        self.path.join(name)
    }

    fn manifest(&self) -> Result<Manifest, Failure> {
        let manifest: Manifest = self.load(MANIFEST)?.ok_or_else(|| {
            Failure::environment(format!(
                "{}: is no sweep's folder, it has no {MANIFEST}; give the folder that `macula sweep` wrote to",
                self.path.display()
            ))
        })?;
        if manifest.version != VERSION {
            return Err(Failure::environment(format!(
                "{}: version {} of the file, this program reads version {VERSION}; sweep again",
                self.file(MANIFEST).display(),
                manifest.version
            )));
        }
        Ok(manifest)
    }

    /// The record of a setting at a size, if it is done.
    ///
    /// # Errors
    /// A file that is no record of this sweep.
    pub fn record(
        &self,
        manifest: &Manifest,
        size: [u32; 2],
        index: usize,
    ) -> Result<Option<Record>, Failure> {
        let name = record_name(size, index);
        let record: Option<Record> = self.load(&name)?;
        let fits = |record: &Record| {
            record.version == VERSION
                && (record.size, record.index) == (size, index)
                && manifest.settings.get(index) == Some(&record.setting)
        };
        match record {
            Some(record) if !fits(&record) => Err(Failure::environment(format!(
                "{}: is of another sweep; remove the file to measure that setting again",
                self.file(&name).display()
            ))),
            record => Ok(record),
        }
    }

    /// All records that are there, by size and setting.
    ///
    /// # Errors
    /// As [`Self::record`].
    pub fn records(&self, manifest: &Manifest) -> Result<Vec<Record>, Failure> {
        let mut records = Vec::new();
        for unit in manifest.units() {
            records.extend(self.record(manifest, unit.0, unit.1)?);
        }
        Ok(records)
    }

    /// Writes a record.
    ///
    /// # Errors
    /// Those of writing.
    pub fn store_record(&self, record: &Record) -> Result<(), Failure> {
        self.store(&record_name(record.size, record.index), record)
    }

    /// The effects' costs, if they were measured.
    ///
    /// # Errors
    /// A file that cannot be read.
    pub fn effects(&self) -> Result<Option<Effects>, Failure> {
        self.load(EFFECTS)
    }

    /// Writes the effects' costs.
    ///
    /// # Errors
    /// Those of writing.
    pub fn store_effects(&self, effects: &Effects) -> Result<(), Failure> {
        self.store(EFFECTS, effects)
    }

    /// Where a picture lies.
    pub fn picture_path(&self, size: [u32; 2], picture: Picture) -> PathBuf {
        let [width, height] = size;
        let name = match picture {
            Picture::Reference => "reference".to_owned(),
            Picture::Of(index) => format!("{index:04}"),
            Picture::Difference(index) => format!("{index:04}-difference"),
        };
        self.path.join(PICTURES).join(format!("{width}x{height}-{name}.jpg"))
    }

    /// A picture's file, if it is there.
    pub fn picture(&self, size: [u32; 2], picture: Picture) -> Option<Vec<u8>> {
        std::fs::read(self.picture_path(size, picture)).ok()
    }

    fn store(&self, name: &str, value: &impl Serialize) -> Result<(), Failure> {
        let path = self.file(name);
        let text = serde_json::to_string_pretty(value)
            .map_err(|error| Failure::environment(format!("{}: {error}", path.display())))?;
        library::write_file(&path, text.as_bytes())
    }

    fn load<T: DeserializeOwned>(&self, name: &str) -> Result<Option<T>, Failure> {
        let path = self.file(name);
        let text = match std::fs::read_to_string(&path) {
            Ok(text) => text,
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(None),
            Err(error) => return Err(Failure::from(macula::Error::io(path, error))),
        };
        serde_json::from_str(&text).map(Some).map_err(|error| {
            Failure::environment(format!(
                "{}: {error}; remove the file to have it made again",
                path.display()
            ))
        })
    }
}

fn record_name([width, height]: [u32; 2], index: usize) -> String {
    format!("{RECORDS}/{width}x{height}-{index:04}.json")
}

impl Manifest {
    /// Every setting at every size, sizes first.
    pub fn units(&self) -> impl Iterator<Item = ([u32; 2], usize)> {
        self.sizes.iter().flat_map(|&size| (0..self.settings.len()).map(move |index| (size, index)))
    }

    /// What of another sweep differs from this one, in a word; the command line itself does not matter.
    pub fn difference(&self, other: &Self) -> Option<&'static str> {
        let compared = [
            (self.program == other.program, "another version of the program"),
            (self.scene == other.scene, "another scene"),
            (self.sizes == other.sizes, "other sizes"),
            (self.hfov_deg == other.hfov_deg, "another field of view"),
            (self.acuity == other.acuity, "another acuity model"),
            (self.base == other.base, "another base"),
            (self.settings == other.settings, "other settings"),
            (self.views == other.views, "other views"),
            (self.runs == other.runs, "another number of runs"),
            (self.fvvdp == other.fvvdp, "FovVideoVDP switched otherwise"),
        ];
        compared.into_iter().find_map(|(same, what)| (!same).then_some(what))
    }
}

impl Record {
    /// Its figures, if it did not fail.
    pub fn figures(&self) -> Option<&super::record::Figures> {
        match &self.outcome {
            Outcome::Measured(figures) => Some(figures),
            Outcome::Failed(_) => None,
        }
    }
}
