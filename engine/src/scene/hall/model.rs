//! The whole scene before it becomes a file, and the search for the level of detail.

use super::mesh::{Detail, Mesh};
use super::{HallOptions, furnish, scatter, structure};
use glam::{DQuat, DVec3};

/// One use of a mesh.
pub struct Place {
    /// Index into [`Model::meshes`].
    pub mesh: usize,
    /// Metres.
    pub translation: DVec3,
    /// Turn.
    pub rotation: DQuat,
}

/// Meshes and where they stand.
#[derive(Default)]
pub struct Model {
    /// Shared by their uses.
    pub meshes: Vec<Mesh>,
    /// The uses.
    pub places: Vec<Place>,
}

impl Model {
    /// Takes a mesh; gives its number.
    pub fn add(&mut self, mesh: Mesh) -> usize {
        self.meshes.push(mesh);
        self.meshes.len() - 1
    }

    /// Uses a mesh once.
    pub fn place(&mut self, mesh: usize, translation: DVec3, rotation: DQuat) {
        self.places.push(Place { mesh, translation, rotation });
    }

    /// Triangles drawn: each use counts.
    pub fn triangles(&self) -> u64 {
        self.places.iter().map(|place| self.meshes[place.mesh].triangles).sum()
    }

    fn at_level(level: f64, counting: bool, seed: u64) -> Self {
        let mut model = Self::default();
        let detail = Detail { level, counting };
        structure::build(&mut model, detail, seed);
        furnish::build(&mut model, detail);
        model
    }

    /// The scene with at most `options.triangles` triangles and as few less as can be: the finest
    /// level of detail that fits, and leaves and pebbles for what is left.
    pub fn new(options: &HallOptions) -> Self {
        let wanted = u64::from(options.triangles);
        // Some litter lies on the floor in any case.
        let fixed = wanted - (wanted / 50).min(24_000);
        let (mut fits, mut exceeds) = (0.01, 24.0);
        for _ in 0..40 {
            let level = 0.5 * (fits + exceeds);
            if Self::at_level(level, true, options.seed).triangles() <= fixed {
                fits = level;
            } else {
                exceeds = level;
            }
        }
        let mut model = Self::at_level(fits, false, options.seed);
        let left = wanted.saturating_sub(model.triangles());
        let litter = scatter::litter(left, options.seed);
        if litter.triangles > 0 {
            let mesh = model.add(litter);
            model.place(mesh, DVec3::ZERO, DQuat::IDENTITY);
        }
        model
    }
}
