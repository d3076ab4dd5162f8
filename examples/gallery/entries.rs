//! What the gallery shows.

/// A picture.
pub struct Entry {
    /// Of its file.
    pub name: &'static str,
    /// The part of the page that it stands in.
    pub part: &'static str,
    pub title: &'static str,
    pub scene: &'static str,
    /// Of `caustica render`, besides scene and outputs.
    pub arguments: &'static str,
    /// What there is to see.
    pub text: &'static str,
}

const CAUSTICS: &str = "Caustics";
const LIGHT: &str = "Light";
const MATTER: &str = "Materials and textures";
const SHAPES: &str = "Shapes";
const CAMERA: &str = "Camera and time";
const ALGORITHMS: &str = "Algorithms";
const COMPOSITIONS: &str = "Compositions";

/// All pictures, in the order of the page.
pub const ENTRIES: &[Entry] = &[
    Entry {
        name: "ring",
        part: CAUSTICS,
        title: "Caustic by reflection",
        scene: "scenes/ring.txt",
        arguments: "--size 480x360 --passes 6",
        text: "The nephroid inside a ring of gold, and inside one of silver.",
    },
    Entry {
        name: "glass-ball",
        part: CAUSTICS,
        title: "Caustic by refraction",
        scene: "scenes/glass-ball.txt",
        arguments: "--size 480x360 --passes 6",
        text: "The light that a ball of glass gathers, in a room whose walls colour each other.",
    },
    Entry {
        name: "pool",
        part: CAUSTICS,
        title: "Caustic through waves",
        scene: "scenes/pool.txt",
        arguments: "--size 480x360 --passes 6",
        text: "Light that came through the waves, seen through the waves: paths that only photons find.",
    },
    Entry {
        name: "gem",
        part: CAUSTICS,
        title: "Cut stones",
        scene: "scenes/gem.txt",
        arguments: "--size 480x360 --passes 6",
        text: "Total reflection inside of diamond, ruby and sapphire, with the sparks that they throw.",
    },
    Entry {
        name: "soft-shadows",
        part: LIGHT,
        title: "Area lights and soft shadows",
        scene: "scenes/window.txt",
        arguments: "--size 480x360 --passes 6",
        text: "A room that a window lights.",
    },
    Entry {
        name: "many-lights",
        part: LIGHT,
        title: "Many lights",
        scene: "scenes/many-lights.txt",
        arguments: "--size 480x360 --passes 6",
        text: "Lights chosen by a tree over power, place and direction.",
    },
    Entry {
        name: "sky",
        part: LIGHT,
        title: "Light from all around",
        scene: "scenes/sky.txt",
        arguments: "--size 480x360 --passes 6",
        text: "A sky lights, and is mirrored and refracted.",
    },
    Entry {
        name: "bulb",
        part: LIGHT,
        title: "A lamp inside of glass",
        scene: "scenes/bulb.txt",
        arguments: "--size 480x360 --passes 6",
        text: "All light of the room has gone through the glass of the bulb: no shadow ray finds it.",
    },
    Entry {
        name: "frosted",
        part: MATTER,
        title: "Rough glass and rough metal",
        scene: "scenes/frosted.txt",
        arguments: "--size 480x360 --passes 6",
        text: "Microfacets of growing roughness.",
    },
    Entry {
        name: "fishbowl",
        part: MATTER,
        title: "Bodies inside of bodies",
        scene: "scenes/fishbowl.txt",
        arguments: "--size 480x360 --passes 6",
        text: "Water in glass, whose common boundary bends light by the ratio of their indices.",
    },
    Entry {
        name: "textures",
        part: MATTER,
        title: "Textures, bumps and normal maps",
        scene: "scenes/textures.txt",
        arguments: "--size 480x360 --passes 6",
        text: "Pictures, tiles to the horizon, marble and wood cut from a block, and reliefs, filtered by the footprint of the ray.",
    },
    Entry {
        name: "teapot",
        part: SHAPES,
        title: "Bézier patches",
        scene: "scenes/teapot.txt",
        arguments: "--size 480x360 --passes 6",
        text: "A pot of bicubic patches, which rays meet as they are: no triangles, no edges in its outline.",
    },
    Entry {
        name: "goblet",
        part: SHAPES,
        title: "Meshes with interpolated normals",
        scene: "scenes/goblet.txt",
        arguments: "--size 480x360 --passes 6",
        text: "Wine in a glass, and a fluted vase, each of many thousand triangles.",
    },
    Entry {
        name: "marbles",
        part: CAMERA,
        title: "Depth of field",
        scene: "scenes/marbles.txt",
        arguments: "--size 480x360 --passes 12 --adaptive",
        text: "A lens of six blades: what is out of focus takes its form.",
    },
    Entry {
        name: "motion",
        part: CAMERA,
        title: "Motion blur",
        scene: "scenes/motion.txt",
        arguments: "--size 480x360 --passes 48 --spp 2 --photons 30k",
        text: "Sails that turn, a ball that falls, and a glass ball that rolls with its caustic.",
    },
    Entry {
        name: "raycast",
        part: ALGORITHMS,
        title: "Ray casting",
        scene: "scenes/glass-ball.txt",
        arguments: "--integrator raycast --size 320x240 --spp 16",
        text: "The course's Phong model: no shadows, nothing mirrored.",
    },
    Entry {
        name: "whitted",
        part: ALGORITHMS,
        title: "Whitted ray tracing",
        scene: "scenes/glass-ball.txt",
        arguments: "--integrator whitted --size 320x240 --passes 8",
        text: "Mirrors, glass and hard shadows.",
    },
    Entry {
        name: "distributed",
        part: ALGORITHMS,
        title: "Distributed ray tracing",
        scene: "scenes/glass-ball.txt",
        arguments: "--integrator distributed --size 320x240 --passes 8",
        text: "Soft shadows; no light between matt walls.",
    },
    Entry {
        name: "path",
        part: ALGORITHMS,
        title: "Path tracing",
        scene: "scenes/glass-ball.txt",
        arguments: "--integrator path --size 320x240 --passes 16",
        text: "Light between walls; caustics come by chance, as grain.",
    },
    Entry {
        name: "pm",
        part: ALGORITHMS,
        title: "Photon mapping",
        scene: "scenes/glass-ball.txt",
        arguments: "--integrator pm --final-gathering none --size 320x240 --passes 4",
        text: "Both maps seen as they are: fast, with seams at edges that stay.",
    },
    Entry {
        name: "ppm",
        part: ALGORITHMS,
        title: "Progressive photon mapping",
        scene: "scenes/glass-ball.txt",
        arguments: "--integrator ppm --size 320x240 --passes 16",
        text: "Radii shrink from pass to pass, so blur goes as noise does.",
    },
    Entry {
        name: "sppm",
        part: ALGORITHMS,
        title: "Stochastic progressive photon mapping",
        scene: "scenes/glass-ball.txt",
        arguments: "--integrator sppm --size 320x240 --passes 16",
        text: "The same with new camera rays in each pass.",
    },
    Entry {
        name: "hybrid",
        part: ALGORITHMS,
        title: "Hybrid",
        scene: "scenes/glass-ball.txt",
        arguments: "--integrator hybrid --size 320x240 --passes 16",
        text: "Paths for what connections find, photons for the rest: the default.",
    },
    Entry {
        name: "still-life",
        part: COMPOSITIONS,
        title: "Still life",
        scene: "scenes/still-life.txt",
        arguments: "--passes 6 --spp 4",
        text: "Surfaces of revolution, a mesh, wine in glass, marble and wood, dented brass, caustics, soft light, depth of field.",
    },
    Entry {
        name: "garden-pool",
        part: COMPOSITIONS,
        title: "Garden pool",
        scene: "scenes/garden-pool.txt",
        arguments: "--passes 8 --spp 3",
        text: "Caustics through waves under a sky, tiles, stone, a ball that drops, glass, gold, instances of a mesh.",
    },
    Entry {
        name: "cabinet",
        part: COMPOSITIONS,
        title: "Cabinet of optics",
        scene: "scenes/cabinet.txt",
        arguments: "--passes 6 --spp 4",
        text: "A ring's nephroid, a ball lens, a cut stone, metals, frosted and thin glass, marble, a relief, light from wall to wall.",
    },
];
