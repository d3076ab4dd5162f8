//! Scenes of the page, and the part of each picture that its strip shows.

/// A scene of the page.
pub struct Entry {
    /// Name of the scene file without extension, and of the strip.
    pub name: &'static str,
    pub title: &'static str,
    /// Left and upper end of the crop \[pixels].
    pub corner: (u32, u32),
    /// Text below the title.
    pub text: &'static str,
}

impl Entry {
    pub fn scene(&self) -> String {
        format!("scenes/{}.txt", self.name)
    }
}

/// All scenes, in the order of the page.
pub const ENTRIES: &[Entry] = &[
    Entry {
        name: "ring",
        title: "Caustic by reflection",
        corner: (50, 28),
        text: "The sun lights a gold ring. The inner wall of the ring reflects light into a curve with a cusp.",
    },
    Entry {
        name: "glass-ball",
        title: "Caustic by refraction",
        corner: (78, 68),
        text: "A glass ball focuses the light of a lamp. The walls of the room tint each other.",
    },
    Entry {
        name: "pool",
        title: "Caustic through waves",
        corner: (66, 32),
        text: "Waves refract sunlight on its way to the tiles and again on its way to the camera.",
    },
    Entry {
        name: "sky",
        title: "Light of the sky",
        corner: (62, 48),
        text: "The sky lights balls and vases, and the sun shines through glass.",
    },
    Entry {
        name: "matte",
        title: "Matte surfaces",
        corner: (70, 36),
        text: "No surface is glass or metal, so the picture has no caustics. Surfaces light each other.",
    },
    Entry {
        name: "motion",
        title: "Motion blur",
        corner: (14, 14),
        text: "A windmill turns while the shutter is open.",
    },
    Entry {
        name: "frosted",
        title: "Rough glass",
        corner: (60, 18),
        text: "The surfaces of the balls are frosted. They blur the caustics below them.",
    },
    Entry {
        name: "god-rays",
        title: "Fog",
        corner: (84, 66),
        text: "Sunlight falls through a window into a room with fog.",
    },
];
