//! Random scenes for tests of plans.
//!
//! Most scenes have few objects, so that plans switch many effects off. Plans check whether a light
//! reaches an object, and on which side. Many random lights are close to the limits of these
//! checks.

use super::sketch::{Light, LightKind, Material, MediumSketch, Moving, Object, Shape, Sketch};
use glam::DVec3;

/// A pseudorandom generator (Steele, Lea, Flood 2014, "Fast splittable pseudorandom number
/// generators").
#[derive(Clone, Debug)]
pub struct Random(u64);

impl Random {
    pub fn new(seed: u64) -> Self {
        Self(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ 0x5851_f42d_4c95_7f2d)
    }

    pub fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let a = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let b = (a ^ (a >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        b ^ (b >> 31)
    }

    /// Returns a uniform random number from 0 to `n` − 1.
    pub fn below(&mut self, n: usize) -> usize {
        (self.next() % n as u64) as usize
    }

    pub fn chance(&mut self, p: f64) -> bool {
        self.between(0.0, 1.0) < p
    }

    /// Returns a number from `low` to `high`, rounded to thousandths so that scene texts stay
    /// short.
    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        let u = (self.next() >> 11) as f64 / (1u64 << 53) as f64;
        ((low + (high - low) * u) * 1000.0).round() / 1000.0
    }

    pub fn pick<T: Copy>(&mut self, of: &[T]) -> T {
        of[self.below(of.len())]
    }

    fn point(&mut self, reach: f64) -> DVec3 {
        DVec3::new(self.between(-reach, reach), self.between(-reach, reach), self.between(-reach, reach))
    }

    /// Returns a random direction of any length, often along an axis.
    fn direction(&mut self) -> DVec3 {
        if self.chance(0.4) {
            return self.pick(&[DVec3::X, DVec3::Y, DVec3::Z]) * self.pick(&[-1.0, 1.0]);
        }
        loop {
            let d = self.point(1.0);
            if d.length() > 0.1 {
                return d;
            }
        }
    }

    fn color(&mut self) -> DVec3 {
        DVec3::new(self.between(0.05, 0.95), self.between(0.05, 0.95), self.between(0.05, 0.95))
    }

    fn strength(&mut self, black: f64) -> DVec3 {
        if self.chance(black) { DVec3::ZERO } else { self.color() * self.pick(&[1.0, 30.0]) }
    }

    /// Returns two edges that are not parallel.
    fn edges(&mut self) -> (DVec3, DVec3) {
        loop {
            let (a, b) = (self.direction() * self.between(0.3, 2.0), self.direction() * self.between(0.3, 2.0));
            if a.cross(b).length() > 0.1 * a.length() * b.length() {
                return (a, b);
            }
        }
    }
}

/// Kinds, probabilities and largest numbers of a random scene's contents.
#[derive(Clone, Copy, Debug)]
struct SceneStyle {
    materials: &'static [Kind],
    lights: &'static [Lamp],
    most_lights: usize,
    black_light: f64,
    emission: f64,
    most_objects: usize,
    flat: f64,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Matt,
    Black,
    Gloss,
    DarkGloss,
    Mirror,
    BlackMirror,
    Glass,
    Frosted,
    Water,
    Polished,
    Brushed,
    Pane,
    Mix,
    Mask,
    Patterned,
    Bumpy,
    RoughMap,
    Panel,
    Clear,
    Filled,
    Prism,
}

#[derive(Clone, Copy, Debug)]
enum Lamp {
    Point,
    Directional,
    Spot,
    SpotAway,
    Sphere,
    Disc,
    DiscAway,
    Rectangle,
    Sky,
    /// Point light in the plane of a flat object, or directional light parallel to it.
    Level,
}

const RECEIVERS: &[Kind] = &[
    Kind::Matt,
    Kind::Black,
    Kind::Gloss,
    Kind::DarkGloss,
    Kind::Brushed,
    Kind::Mix,
    Kind::Patterned,
    Kind::Bumpy,
    Kind::Panel,
];
const DARK: &[Kind] = &[Kind::Black, Kind::Black, Kind::Mirror, Kind::Glass, Kind::Mix, Kind::DarkGloss];
const BLACK: &[Kind] = &[Kind::Black, Kind::Mirror, Kind::Mix];
const CASTERS: &[Kind] =
    &[Kind::Mirror, Kind::BlackMirror, Kind::Glass, Kind::Frosted, Kind::Water, Kind::Polished, Kind::Pane, Kind::Mix];
const ANY: &[Kind] = &[
    Kind::Matt,
    Kind::Black,
    Kind::Gloss,
    Kind::DarkGloss,
    Kind::Mirror,
    Kind::BlackMirror,
    Kind::Glass,
    Kind::Frosted,
    Kind::Water,
    Kind::Polished,
    Kind::Brushed,
    Kind::Pane,
    Kind::Mix,
    Kind::Mix,
    Kind::Mask,
    Kind::Patterned,
    Kind::Bumpy,
    Kind::RoughMap,
    Kind::Panel,
    Kind::Clear,
    Kind::Filled,
    Kind::Prism,
];
const MURKY: &[Kind] = &[Kind::Clear, Kind::Clear, Kind::Filled, Kind::Prism, Kind::Matt, Kind::Mix];
const HARD: &[Lamp] = &[Lamp::Point, Lamp::Directional, Lamp::Spot, Lamp::Level];
const LEVEL: &[Lamp] = &[Lamp::Level];
const AWAY: &[Lamp] = &[Lamp::SpotAway, Lamp::DiscAway];
const LAMPS: &[Lamp] = &[
    Lamp::Point,
    Lamp::Directional,
    Lamp::Spot,
    Lamp::SpotAway,
    Lamp::Sphere,
    Lamp::Disc,
    Lamp::DiscAway,
    Lamp::Rectangle,
    Lamp::Sky,
    Lamp::Level,
];

const PLAIN: SceneStyle = SceneStyle {
    materials: ANY,
    lights: LAMPS,
    most_lights: 3,
    black_light: 0.1,
    emission: 0.1,
    most_objects: 5,
    flat: 0.4,
};

const SCENE_STYLES: [SceneStyle; 11] = [
    PLAIN,
    SceneStyle { lights: HARD, emission: 0.0, ..PLAIN },
    SceneStyle { lights: AWAY, emission: 0.0, black_light: 0.0, ..PLAIN },
    SceneStyle { lights: AWAY, emission: 0.0, materials: BLACK, ..PLAIN },
    SceneStyle { materials: RECEIVERS, ..PLAIN },
    SceneStyle { materials: DARK, most_objects: 4, ..PLAIN },
    SceneStyle { materials: CASTERS, ..PLAIN },
    SceneStyle { most_objects: 1, lights: HARD, emission: 0.2, flat: 0.8, most_lights: 2, ..PLAIN },
    SceneStyle { most_objects: 1, lights: LEVEL, emission: 0.0, flat: 1.0, black_light: 0.0, ..PLAIN },
    SceneStyle { materials: MURKY, ..PLAIN },
    SceneStyle { black_light: 0.9, emission: 0.0, most_lights: 7, ..PLAIN },
];

/// Returns the random scene of a seed.
pub fn sketch(seed: u64) -> Sketch {
    let r = &mut Random::new(seed);
    let style = r.pick(&SCENE_STYLES);
    let mut sketch = Sketch {
        camera: String::new(),
        background: if r.chance(0.3) { DVec3::ZERO } else { r.color() },
        lights: Vec::new(),
        materials: Vec::new(),
        objects: Vec::new(),
        filling: None,
        motion: None,
    };
    for _ in 0..1 + r.below(4) {
        add_material(r, &style, &mut sketch);
    }
    for _ in 0..1 + r.below(style.most_objects) {
        add_object(r, &style, &mut sketch);
    }
    if r.chance(0.05) {
        sketch.objects.clear();
    }
    for _ in 0..r.below(style.most_lights + 1) {
        add_light(r, &style, &mut sketch);
    }
    // A scene with an ambient medium may not have light from infinity.
    let endless = |l: &Light| matches!(l.kind, LightKind::Environment | LightKind::Directional(_));
    if r.chance(0.1) && !sketch.lights.iter().any(endless) {
        sketch.filling =
            Some(r.pick(&[MediumSketch::Fog, MediumSketch::Soot, MediumSketch::Flame, MediumSketch::Nothing]));
    }
    sketch.camera = camera(r, &sketch);
    if r.chance(0.15) {
        sketch.camera += &format!("  aperture {}  focusDistance {}", r.between(0.01, 0.5), r.between(1.0, 9.0));
    }
    if r.chance(0.2) {
        sketch.motion = motion(r, &sketch);
    }
    sketch
}

/// Returns a random part of the scene that moves, with its transforms; `None` if no part can move.
fn motion(r: &mut Random, sketch: &Sketch) -> Option<(Moving, String)> {
    let lights: Vec<usize> =
        (0..sketch.lights.len()).filter(|i| !matches!(sketch.lights[*i].kind, LightKind::Environment)).collect();
    let moving = match r.below(3) {
        0 => Moving::Camera,
        1 if !lights.is_empty() => Moving::Light(r.pick(&lights)),
        _ if !sketch.objects.is_empty() => Moving::Object(r.below(sketch.objects.len())),
        _ => return None,
    };
    let by = r.point(1.0);
    let shift = format!("Translate {} {} {}", by.x, by.y, by.z);
    let turn = format!("YRotate {}", r.between(-90.0, 90.0));
    Some((moving, r.pick(&[shift.as_str(), turn.as_str(), &format!("{shift}  {turn}")]).to_owned()))
}

/// Returns the scene `sketch` with one more object or light.
pub fn with_one_more(sketch: &Sketch, seed: u64) -> Sketch {
    let r = &mut Random::new(seed);
    let mut more = sketch.clone();
    let style = r.pick(&SCENE_STYLES);
    if r.chance(0.5) {
        add_light(r, &style, &mut more);
    } else {
        add_material(r, &style, &mut more);
        add_object(r, &style, &mut more);
    }
    more
}

fn camera(r: &mut Random, sketch: &Sketch) -> String {
    let (center, at) = match sketch.objects.first().map(|o| &o.shape) {
        Some(Shape::Sphere(c, _) | Shape::Ellipsoid(c, ..) | Shape::Mesh(_, c, ..)) if r.chance(0.2) => {
            (*c + r.point(0.05), *c + r.direction())
        }
        // The camera looks along the plane of a flat object.
        Some(Shape::Rectangle(c, a, b)) if r.chance(0.1) => (*c - *a * 2.0, *c + *b * 0.5),
        _ => {
            let center = r.direction().normalize() * r.between(4.0, 9.0);
            let at = if r.chance(0.1) { center * 2.0 } else { r.point(1.0) };
            (center, at)
        }
    };
    let up = if (at - center).normalize().y.abs() > 0.9 { "0 0 1" } else { "0 1 0" };
    let angle = r.pick(&[25, 50, 100]);
    let [c, a] = [center, at].map(|v| format!("{} {} {}", v.x, v.y, v.z));
    format!("center {c}  lookAt {a}  up {up}  angle {angle}  width 12  height 9")
}

fn add_material(r: &mut Random, style: &SceneStyle, sketch: &mut Sketch) {
    let kind = r.pick(style.materials);
    let before = sketch.materials.len();
    let tint = if r.chance(0.5) { r.color() } else { DVec3::ZERO };
    let material = match kind {
        Kind::Matt => Material::Diffuse(r.color()),
        Kind::Black => Material::Diffuse(DVec3::ZERO),
        Kind::Gloss => Material::Phong(r.color(), r.color(), r.between(0.0, 60.0)),
        Kind::DarkGloss => {
            let specular = if r.chance(0.4) { DVec3::ZERO } else { r.color() };
            Material::Phong(DVec3::ZERO, specular, r.between(0.0, 60.0))
        }
        Kind::Mirror => Material::Mirror(r.color()),
        Kind::BlackMirror => Material::Mirror(DVec3::ZERO),
        Kind::Glass => Material::Dielectric(r.pick(&[1.5, 1.0, 2.4]), tint, 0.0, r.below(3) as u8),
        Kind::Frosted => Material::Dielectric(1.5, tint, r.between(0.01, 0.8), r.below(3) as u8),
        Kind::Water => Material::Dielectric(1.33, r.color(), 0.0, r.below(3) as u8),
        Kind::Polished => Material::Conductor(r.pick(&[0.0, 0.1, 0.3])),
        Kind::Brushed => Material::Conductor(r.pick(&[0.31, 0.6, 1.0])),
        Kind::Pane => Material::Thin(1.5),
        Kind::Mix | Kind::Mask if before == 0 => Material::Mirror(r.color()),
        Kind::Mix => mix(r, sketch, before),
        Kind::Mask => match mix(r, sketch, before) {
            Material::Mix(a, b, _) => Material::Mask(a, b),
            other => other,
        },
        Kind::Patterned => Material::Patterned(r.strength(0.5).min(DVec3::ONE), tint),
        Kind::Bumpy => Material::Bumpy(r.color(), r.between(0.01, 0.3)),
        Kind::RoughMap => Material::RoughMap(r.between(0.0, 0.4), r.between(0.2, 1.0)),
        Kind::Panel => Material::Panel(r.strength(0.5), tint),
        Kind::Clear => Material::Clear(r.pick(&MediumSketch::ALL)),
        Kind::Filled => Material::Filled(r.pick(&[1.0, 1.33]), r.pick(&MediumSketch::ALL)),
        Kind::Prism => Material::Prism(r.pick(&["SF11", "diamond"])),
    };
    sketch.materials.push(material);
}

/// Returns a mix of two earlier materials, of which at most one is a body.
fn mix(r: &mut Random, sketch: &Sketch, before: usize) -> Material {
    let (a, b, amount) = (r.below(before), r.below(before), r.pick(&[0.0, 0.25, 0.5, 1.0]));
    let body = |i| body_material_index(sketch, i);
    let clear = |i: usize| matches!(sketch.materials[i], Material::Clear(_));
    if clear(a) || clear(b) {
        return Material::Mirror(DVec3::splat(amount));
    }
    match (body(a), body(b)) {
        (Some(x), Some(y)) if x != y => Material::Mix(a, a, amount),
        _ => Material::Mix(a, b, amount),
    }
}

/// Returns the index of the body material in material `i`, which may be a mix; `None` if there is
/// none.
fn body_material_index(sketch: &Sketch, i: usize) -> Option<usize> {
    match sketch.materials[i] {
        Material::Mix(a, b, _) | Material::Mask(a, b) => {
            body_material_index(sketch, a).or(body_material_index(sketch, b))
        }
        Material::Dielectric(..) | Material::Clear(_) | Material::Filled(..) | Material::Prism(_) => Some(i),
        _ => None,
    }
}

fn add_object(r: &mut Random, style: &SceneStyle, sketch: &mut Sketch) {
    let center = match sketch.objects.last().map(|o| &o.shape) {
        // The new object is around the center of the last sphere, so that one body may be inside
        // another.
        Some(Shape::Sphere(c, _)) if r.chance(0.4) => *c,
        _ => r.point(2.0),
    };
    let turn = r.between(0.0, 90.0);
    let shape = if r.chance(style.flat) {
        let (a, b) = r.edges();
        match r.below(4) {
            0 => Shape::Plane(r.point(2.0), r.direction()),
            1 => Shape::Disc(center, r.direction(), r.between(0.3, 2.0)),
            2 => Shape::Triangle([center, center + a, center + b]),
            _ => Shape::Rectangle(center, a, b),
        }
    } else {
        match r.below(5) {
            0 => {
                let axes = DVec3::new(r.between(0.2, 1.5), r.between(0.2, 1.5), r.between(0.2, 1.5));
                Shape::Ellipsoid(center, turn, axes)
            }
            1 => {
                let mesh = r.pick(&["tests/scenes/coarse-ball.obj", "mesh/gem.obj"]);
                Shape::Mesh(mesh, center, turn, r.between(0.3, 1.2))
            }
            _ => Shape::Sphere(center, r.between(0.2, 1.2)),
        }
    };
    let material = sketch.materials.len() - 1 - r.below(sketch.materials.len().min(3));
    let clear = matches!(sketch.materials[material], Material::Clear(_));
    let emits = !matches!(shape, Shape::Plane(..)) && r.chance(style.emission) && !clear;
    let emission = if emits { r.color() } else { DVec3::ZERO };
    // Unbounded shapes may not emit.
    let shape = match (shape, &sketch.materials[material]) {
        (Shape::Plane(p, n), Material::Panel(..)) => Shape::Disc(p, n, 1.0),
        (shape, _) => shape,
    };
    sketch.objects.push(Object { material, emission, shape });
}

fn add_light(r: &mut Random, style: &SceneStyle, sketch: &mut Sketch) {
    // Objects are within about 4 of the origin. Lights that shine along `out` shine away from the
    // objects or past them.
    let out = r.direction().normalize();
    let place = if r.chance(0.3) { r.point(2.0) } else { out * r.between(3.0, 8.0) };
    let angle = r.pick(&[8.0, 30.0, 90.0, 179.0, 250.0]);
    let penumbra = r.pick(&[0.0, 0.2, 0.5]) * angle;
    let sky = || sketch.lights.iter().any(|l| matches!(l.kind, LightKind::Environment));
    let lamp = match r.pick(style.lights) {
        Lamp::Sky | Lamp::Directional if sketch.filling.is_some() => Lamp::Point,
        lamp => lamp,
    };
    let kind = match lamp {
        Lamp::Sky if sky() => LightKind::Point(place),
        Lamp::Sky => LightKind::Environment,
        Lamp::Point => LightKind::Point(place),
        Lamp::Directional => LightKind::Directional(r.direction()),
        Lamp::Spot => LightKind::Spot(place, r.point(2.0) - place, angle, penumbra),
        Lamp::SpotAway => {
            let beside = out + r.direction().normalize() * r.pick(&[0.0, 0.7, 1.4]);
            LightKind::Spot(out * 6.0, if beside.length() > 0.1 { beside } else { out }, r.pick(&[8.0, 40.0]), 0.0)
        }
        Lamp::Sphere => LightKind::Sphere(place, r.between(0.1, 1.0)),
        Lamp::Disc => LightKind::Disc(place, r.direction(), r.between(0.1, 1.0)),
        Lamp::DiscAway => LightKind::Disc(out * 6.0, out, r.between(0.1, 1.0)),
        Lamp::Rectangle => {
            let (a, b) = r.edges();
            LightKind::Rectangle(place, a, b)
        }
        Lamp::Level => light_level_with_object(r, sketch),
    };
    let kind = match kind {
        LightKind::Directional(_) if sketch.filling.is_some() => LightKind::Point(place),
        kind => kind,
    };
    sketch.lights.push(Light { kind, strength: r.strength(style.black_light) });
}

/// Returns a point light in the plane of the first flat object, or a directional light along it.
fn light_level_with_object(r: &mut Random, sketch: &Sketch) -> LightKind {
    let (place, edges) = match sketch.objects.iter().map(|o| &o.shape).find(|s| s.is_flat()) {
        Some(Shape::Rectangle(c, a, b)) => (*c, [*a, *b]),
        Some(Shape::Disc(c, n, _) | Shape::Plane(c, n)) => {
            (*c, [n.any_orthogonal_vector(), n.cross(DVec3::new(n.y + 1.0, n.z, n.x))])
        }
        _ => return LightKind::Point(r.point(2.0)),
    };
    let (s, t) = (r.between(-1.0, 2.0), r.between(-1.0, 2.0));
    match edges[0] * s + edges[1] * t {
        along if r.chance(0.5) || along.length() < 0.1 => LightKind::Point(place + along),
        along => LightKind::Directional(along),
    }
}
