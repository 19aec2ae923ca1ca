//! The generated default scene: a columned hall with sunlight and lamps, as a binary glTF file.
//!
//! The same options give the same bytes on any machine: the geometry comes from arithmetic that
//! IEEE 754 fixes (`hall/math.rs`), and its random numbers from an own generator.

mod furnish;
mod glb;
mod lights;
mod materials;
mod math;
mod mesh;
mod model;
mod scatter;
mod shapes;
mod structure;
mod textures;

#[cfg(test)]
mod tests;

use crate::error::{Error, Result};
use crate::io::image_file;
use std::path::Path;

/// How large the hall is, in triangles and lights.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct HallOptions {
    /// Triangles drawn, each use of a shared mesh counted; 10 000..=5 000 000. The scene has at
    /// most a few less.
    pub triangles: u32,
    /// Lights: one sun and `lights - 1` point and spot lights; 1..=1000.
    pub lights: u32,
    /// What varies: stains and veins of the materials, litter, small lamps.
    pub seed: u64,
    /// Lamps end at 8 to 14 m. Otherwise, glTF's default, they have no range: every lamp reaches every
    /// surface, and none can be left out.
    pub ranged_lights: bool,
}

impl Default for HallOptions {
    fn default() -> Self {
        Self { triangles: 250_000, lights: 256, seed: 1, ranged_lights: false }
    }
}

impl HallOptions {
    /// [`Error::Setting`] where a number is out of range.
    pub fn check(&self) -> Result<()> {
        if !(10_000..=5_000_000).contains(&self.triangles) {
            let asked = self.triangles;
            return Err(Error::Setting(format!("hall: triangles are 10000 to 5000000, not {asked}")));
        }
        if !(1..=1000).contains(&self.lights) {
            return Err(Error::Setting(format!("hall: lights are 1 to 1000, not {}", self.lights)));
        }
        Ok(())
    }
}

/// The hall as the bytes of a `.glb` file.
///
/// # Errors
/// [`Error::Setting`] for options out of range.
pub fn generate_glb(options: &HallOptions) -> Result<Vec<u8>> {
    options.check()?;
    glb::file(options)
}

/// Writes the hall to `path`, which appears only when it is whole.
///
/// # Errors
/// [`Error::Setting`] for options out of range, [`Error::Io`] where the file cannot be written.
pub fn write_glb(path: impl AsRef<Path>, options: &HallOptions) -> Result<()> {
    let bytes = generate_glb(options)?;
    image_file::write_atomically(path, |file| file.write_all(&bytes))
}
