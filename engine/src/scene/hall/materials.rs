//! The hall's materials: one table, from which the glTF file's materials are written.

use super::textures::Picture;

/// One of the hall's materials, in the order of [`TABLE`].
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
#[repr(u8)]
#[allow(missing_docs, reason = "the names say what they are")]
pub enum Material {
    Limestone,
    ColumnMarble,
    TileLight,
    TileDark,
    TileClay,
    Oak,
    Brick,
    Plaster,
    GiltOrnament,
    AgedBronze,
    WroughtIron,
    PolishedGold,
    Copper,
    Chrome,
    CobaltGlaze,
    CeladonGlaze,
    Terracotta,
    BannerCrimson,
    BannerAzure,
    BannerForest,
    RugWool,
    LanternGlass,
    Embers,
    LatticeScreen,
    FallenLeaf,
    Pebble,
    NeroMarble,
    RedRubber,
    BlueSatinMetal,
    WhiteLacquer,
    RoofSlate,
    DaisMarble,
}

/// What the table says of one material.
pub struct Look {
    /// Which it is; its place in the table.
    pub material: Material,
    /// The name in the file.
    pub name: &'static str,
    /// Linear base colour, times the texture's.
    pub color: [f64; 3],
    /// Metallic, times the texture's.
    pub metallic: f64,
    /// Roughness, times the texture's.
    pub roughness: f64,
    /// Linear emitted radiance, times the texture's.
    pub emission: [f64; 3],
    /// Metres that one repeat of the textures covers.
    pub tile_m: f64,
    /// Base colour, metallic-roughness, normal, occlusion and emission.
    pub pictures: [Option<Picture>; 5],
    /// Alpha below 0.5 is a hole.
    pub mask: bool,
    /// Both sides are seen.
    pub double_sided: bool,
}

impl Material {
    /// Metres that one repeat of the textures covers.
    pub fn tile_m(self) -> f64 {
        self.look().tile_m
    }

    /// This material's line of the table.
    pub fn look(self) -> &'static Look {
        let look = &TABLE[self as usize];
        debug_assert_eq!(look.material, self);
        look
    }
}

/// A plain line of the table: without emission, opaque, one-sided.
const fn look(
    material: Material,
    name: &'static str,
    color: [f64; 3],
    [metallic, roughness]: [f64; 2],
    tile_m: f64,
    [base, surface, normal]: [Option<Picture>; 3],
) -> Look {
    Look {
        material,
        name,
        color,
        metallic,
        roughness,
        emission: [0.0; 3],
        tile_m,
        pictures: [base, surface, normal, None, None],
        mask: false,
        double_sided: false,
    }
}

impl Look {
    const fn occluded(mut self, picture: Picture) -> Self {
        self.pictures[3] = Some(picture);
        self
    }

    const fn emitting(mut self, emission: [f64; 3], picture: Option<Picture>) -> Self {
        self.emission = emission;
        self.pictures[4] = picture;
        self
    }

    const fn masked(mut self) -> Self {
        self.mask = true;
        self
    }

    const fn both_sides(mut self) -> Self {
        self.double_sided = true;
        self
    }
}

/// All materials. Emission is in the units of radiance in which a lit white wall is near 0.3.
pub static TABLE: [Look; 32] = {
    use Material as M;
    use Picture as P;
    const NONE: [Option<Picture>; 3] = [None; 3];
    const STONE: [Option<Picture>; 3] = [Some(P::StoneBase), Some(P::StoneSurface), Some(P::StoneNormal)];
    const PALE: [Option<Picture>; 3] = [Some(P::MarblePale), Some(P::MarbleSurface), None];
    const DARK: [Option<Picture>; 3] = [Some(P::MarbleDark), Some(P::MarbleSurface), None];
    const CLAY: [Option<Picture>; 3] = [Some(P::ClayBase), Some(P::ClaySurface), Some(P::ClayNormal)];
    const WOOD: [Option<Picture>; 3] = [Some(P::WoodBase), Some(P::WoodSurface), Some(P::WoodNormal)];
    const BRICK: [Option<Picture>; 3] = [Some(P::BrickBase), Some(P::BrickSurface), Some(P::BrickNormal)];
    const PLASTER: [Option<Picture>; 3] = [Some(P::PlasterBase), None, Some(P::PlasterNormal)];
    const ROUGH: [Option<Picture>; 3] = [None, None, Some(P::PlasterNormal)];
    const HAMMERED: [Option<Picture>; 3] = [None, Some(P::HammeredSurface), Some(P::HammeredNormal)];
    const PATINA: [Option<Picture>; 3] = [Some(P::PatinaBase), Some(P::PatinaSurface), None];
    const BRUSHED: [Option<Picture>; 3] = [None, Some(P::BrushedSurface), Some(P::BrushedNormal)];
    const BANNER: [Option<Picture>; 3] = [Some(P::Banner), None, Some(P::WeaveNormal)];
    [
        look(M::Limestone, "limestone blocks", [0.92, 0.86, 0.76], [0.0, 1.0], 2.4, STONE),
        look(M::ColumnMarble, "column marble", [0.95, 0.92, 0.87], [0.0, 0.8], 2.0, PALE),
        look(M::TileLight, "light floor marble", [0.95, 0.93, 0.9], [0.0, 0.35], 1.5, PALE),
        look(M::TileDark, "dark floor marble", [0.8, 0.85, 0.8], [0.0, 0.3], 1.5, DARK),
        look(M::TileClay, "clay tiles", [1.0, 1.0, 1.0], [0.0, 1.0], 2.0, CLAY),
        look(M::Oak, "oak", [1.0, 1.0, 1.0], [0.0, 1.0], 1.6, WOOD),
        look(M::Brick, "brick", [1.0, 1.0, 1.0], [0.0, 1.0], 1.6, BRICK).occluded(P::BrickOcclusion),
        look(M::Plaster, "vault plaster", [0.86, 0.82, 0.74], [0.0, 0.95], 3.0, PLASTER),
        look(M::GiltOrnament, "gilt ornament", [1.0, 0.77, 0.34], [1.0, 0.32], 0.5, HAMMERED),
        look(M::AgedBronze, "aged bronze", [0.55, 0.39, 0.22], [1.0, 0.55], 0.6, PATINA),
        look(M::WroughtIron, "wrought iron", [0.16, 0.15, 0.15], [1.0, 0.6], 0.4, HAMMERED),
        look(M::PolishedGold, "polished gold", [1.0, 0.78, 0.34], [1.0, 0.12], 1.0, NONE),
        look(M::Copper, "brushed copper", [0.95, 0.64, 0.54], [1.0, 0.3], 0.8, BRUSHED),
        look(M::Chrome, "chrome", [0.78, 0.79, 0.8], [1.0, 0.04], 1.0, NONE),
        look(M::CobaltGlaze, "cobalt glaze", [0.03, 0.08, 0.4], [0.0, 0.12], 1.0, NONE),
        look(M::CeladonGlaze, "celadon glaze", [0.36, 0.56, 0.42], [0.0, 0.2], 1.0, NONE),
        look(M::Terracotta, "terracotta", [0.6, 0.28, 0.16], [0.0, 0.85], 1.0, ROUGH),
        look(M::BannerCrimson, "crimson banner", [0.7, 0.06, 0.07], [0.0, 0.85], 1.0, BANNER).both_sides(),
        look(M::BannerAzure, "azure banner", [0.06, 0.16, 0.6], [0.0, 0.85], 1.0, BANNER).both_sides(),
        look(M::BannerForest, "forest banner", [0.05, 0.32, 0.12], [0.0, 0.85], 1.0, BANNER).both_sides(),
        look(
            M::RugWool,
            "rug",
            [1.0, 1.0, 1.0],
            [0.0, 0.95],
            2.4,
            [Some(P::Rug), None, Some(P::WeaveNormal)],
        ),
        look(
            M::LanternGlass,
            "lantern glass",
            [0.9, 0.75, 0.5],
            [0.0, 0.25],
            0.5,
            [Some(P::Glass), None, None],
        )
        .emitting([6.0, 3.7, 1.7], Some(P::Glass)),
        look(M::Embers, "embers", [0.12, 0.08, 0.07], [0.0, 0.9], 0.5, NONE)
            .emitting([9.0, 2.6, 0.5], Some(P::Embers)),
        look(
            M::LatticeScreen,
            "lattice screen",
            [0.7, 0.55, 0.32],
            [1.0, 0.45],
            1.0,
            [Some(P::Lattice), None, None],
        )
        .masked()
        .both_sides(),
        look(M::FallenLeaf, "fallen leaves", [1.0, 1.0, 1.0], [0.0, 0.8], 0.2, [Some(P::Leaf), None, None])
            .masked()
            .both_sides(),
        look(M::Pebble, "pebbles", [0.5, 0.47, 0.43], [0.0, 0.9], 0.4, ROUGH),
        look(M::NeroMarble, "black marble", [0.25, 0.25, 0.27], [0.0, 0.25], 1.5, DARK),
        look(M::RedRubber, "red rubber", [0.55, 0.03, 0.02], [0.0, 0.75], 1.0, NONE),
        look(M::BlueSatinMetal, "blue satin metal", [0.12, 0.28, 0.75], [1.0, 0.42], 0.8, BRUSHED),
        look(M::WhiteLacquer, "white lacquer", [0.86, 0.86, 0.84], [0.0, 0.06], 1.0, NONE),
        look(M::RoofSlate, "roof slate", [0.12, 0.13, 0.15], [0.0, 0.9], 2.0, ROUGH),
        look(M::DaisMarble, "dais marble", [0.92, 0.88, 0.86], [0.0, 0.4], 2.0, PALE),
    ]
};
