//! Goes through the settings: skips what is done, records what fails, stops where nothing more can be kept.

use super::folder::{Folder, Picture};
use super::measure::{Bench, Measured, Subject};
use super::record::{Machine, Manifest, Outcome, Record, VERSION};
use super::thumbnail::thumbnail;
use crate::failure::Failure;
use crate::library;
use crate::page::picture::difference_times_4;
use crate::progress::Steps;
use glam::DMat4;
use macula::fovea::{AcuityModel, DisplayGeometry};
use macula::headless::{GpuContent, HeadlessDevice};

/// One of several parts of a sweep.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shard {
    /// From 1.
    pub number: usize,
    /// How many there are.
    pub of: usize,
}

/// `K/N`.
pub fn parse_shard(text: &str) -> Result<Shard, String> {
    let shard = text.split_once('/').and_then(|(number, of)| Some((number.parse().ok()?, of.parse().ok()?)));
    match shard {
        Some((number, of)) if (1..=of).contains(&number) && of <= 10_000 => Ok(Shard { number, of }),
        _ => Err("expected K/N, as in 1/4: the first of four parts".into()),
    }
}

impl Shard {
    /// Whether the unit at a place belongs to it: units are dealt out in turn, so that parts take about the
    /// same time.
    pub fn has(self, place: usize) -> bool {
        place % self.of == self.number - 1
    }
}

/// What every size shares.
pub struct Sweep<'a> {
    pub folder: &'a Folder,
    pub manifest: &'a Manifest,
    pub device: &'a HeadlessDevice,
    pub content: &'a GpuContent,
    pub machine: Machine,
    pub acuity: &'a AcuityModel,
    pub shard: Option<Shard>,
    /// The eye's pose for a display.
    pub world_from_view: &'a dyn Fn(&DisplayGeometry) -> Result<DMat4, Failure>,
}

impl Sweep<'_> {
    /// The units of this part that are not done.
    ///
    /// # Errors
    /// Records that cannot be read.
    pub fn left(&self) -> Result<Vec<([u32; 2], usize)>, Failure> {
        let mut left = Vec::new();
        for (place, (size, index)) in self.manifest.units().enumerate() {
            let mine = self.shard.is_none_or(|shard| shard.has(place));
            if mine && self.folder.record(self.manifest, size, index)?.is_none() {
                left.push((size, index));
            }
        }
        Ok(left)
    }

    /// Measures what is left.
    ///
    /// # Errors
    /// What cannot be written, and a device that no longer renders; what is done stays.
    pub fn run(&self) -> Result<(), Failure> {
        let left = self.left()?;
        let weight = |size: [u32; 2]| size.map(f64::from).iter().product::<f64>();
        let mut steps = Steps::long(left.iter().map(|&(size, _)| weight(size)).sum::<f64>() * 1.02 + 1.0);
        for &size in &self.manifest.sizes {
            let of_size: Vec<_> =
                left.iter().filter(|(of, _)| *of == size).map(|&(_, index)| index).collect();
            if of_size.is_empty() {
                continue;
            }
            let [width, height] = size;
            steps.next_of_weight(&format!("{width}x{height}, reference"), weight(size) * 0.02);
            let mut bench = match self.bench(size) {
                Ok(bench) => bench,
                Err(failure) => {
                    self.fail_all(size, &of_size, &failure)?;
                    continue;
                }
            };
            self.store_picture(size, Picture::Reference, bench.picture())?;
            for index in of_size {
                let setting = &self.manifest.settings[index];
                steps.next_of_weight(&format!("{width}x{height}, {setting}"), weight(size));
                let measured = bench.measure(setting, |share| steps.within(share));
                self.store(size, index, &mut bench, measured)?;
            }
        }
        Ok(())
    }

    fn bench(&self, size: [u32; 2]) -> Result<Bench<'_>, Failure> {
        let display = DisplayGeometry::symmetric(size, self.manifest.hfov_deg);
        let subject = Subject {
            device: self.device,
            content: self.content,
            display,
            world_from_view: (self.world_from_view)(&display)?,
            views: &self.manifest.views,
            runs: self.manifest.runs,
            acuity: self.acuity,
        };
        Bench::new(subject, &self.manifest.reference)
    }

    fn store(
        &self,
        size: [u32; 2],
        index: usize,
        bench: &mut Bench<'_>,
        measured: Result<Measured, Failure>,
    ) -> Result<(), Failure> {
        let outcome = match measured {
            Ok(Measured { figures, picture }) => {
                self.store_picture(size, Picture::Of(index), &picture)?;
                let difference = difference_times_4(bench.picture(), &picture);
                self.store_picture(size, Picture::Difference(index), &difference)?;
                Outcome::Measured(Box::new(figures))
            }
            Err(failure) => {
                // A lost device would fail every other setting, too.
                bench.check_device()?;
                Outcome::Failed(reason(&failure))
            }
        };
        self.store_outcome(size, index, outcome)
    }

    fn fail_all(&self, size: [u32; 2], indices: &[usize], failure: &Failure) -> Result<(), Failure> {
        let line = format!("the reference: {}", reason(failure));
        indices.iter().try_for_each(|&index| self.store_outcome(size, index, Outcome::Failed(line.clone())))
    }

    fn store_outcome(&self, size: [u32; 2], index: usize, outcome: Outcome) -> Result<(), Failure> {
        self.folder.store_record(&Record {
            version: VERSION,
            index,
            size,
            setting: self.manifest.settings[index].clone(),
            machine: self.machine.clone(),
            outcome,
        })
    }

    fn store_picture(&self, size: [u32; 2], picture: Picture, rgba: &[u8]) -> Result<(), Failure> {
        library::write_file(&self.folder.picture_path(size, picture), &thumbnail(rgba, size)?)
    }
}

fn reason(failure: &Failure) -> String {
    let line = failure.line().unwrap_or_default();
    line.strip_prefix("error: ").unwrap_or(&line).to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shards_are_read_or_refused() {
        assert_eq!(parse_shard("2/3"), Ok(Shard { number: 2, of: 3 }));
        for bad in ["", "1", "0/3", "4/3", "1/0", "a/b", "1/99999"] {
            assert!(parse_shard(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn every_unit_belongs_to_one_shard() {
        for of in 1..6 {
            for place in 0..20 {
                let having = (1..=of).filter(|&number| Shard { number, of }.has(place));
                assert_eq!(having.count(), 1);
            }
        }
    }
}
