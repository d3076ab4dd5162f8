//! Caustica: a photon-mapping renderer that tells what accuracy costs.
//!
//! # The walk of one photon
//!
//! A pass has a [`Key`](sampling::Key); path `i` of it has the key `pass.with(i)`, and every random decision is a function of
//! such a key and the decision's name. [`PhotonSource::emit`](photon::PhotonSource::emit) chooses a light in proportion to its
//! power, to the part of it that can reach casters, or to what a pilot found useful, and a ray from it; the ray carries its flux over its density
//! and the number of paths. [`PhotonPass::trace`](photon::PhotonPass::trace) then repeats: nearest hit
//! ([`PathRay::next_vertex`](scene::PathRay::next_vertex)), absorption on the way, in a [`Medium`](medium::Medium) a beam and a place where it is scattered, a stored [`Photon`](photon::Photon) where the surface
//! stores them and the class is wanted, a direction from the [`Bsdf`](bsdf::Bsdf), roulette on the ratio of throughputs.
//! The photons become a [`PhotonMap`](photon::PhotonMap).
//!
//! # The walk of one camera ray
//!
//! [`Algorithm::Hybrid`](integrate::Algorithm::Hybrid), and every other algorithm in its own way, sends a ray through a point
//! of the pixel that its filter chose ([`Camera::ray`](camera::Camera::ray)) and walks through mirrors and glass, both ways where
//! both matter. At the first other surface it adds emission, direct light by shadow rays, and what photons that met casters first
//! brought there ([`PhotonMap::estimate`](photon::PhotonMap::estimate)), then walks on. [`render`](render::render) takes the mean
//! over passes whose radii shrink.
//!
//! # A scene in code
//!
//! ```
//! use caustica::camera::Camera;
//! use caustica::integrate::{Algorithm, Settings, Silent};
//! use caustica::scene::{LightStrength, Material, SceneBuilder, SourceKind};
//! use caustica::shape::{Plane, Shape, Sphere};
//! use glam::{DVec3, Vec3};
//!
//! let mut builder = SceneBuilder::new();
//! let white = builder.material(Material::diffuse(Vec3::splat(0.8)));
//! let glass = builder.material(Material::dielectric(1.5, Vec3::ZERO));
//! builder
//!     .plane(Plane::new(DVec3::ZERO, DVec3::Y), white, Vec3::ZERO)
//!     .shape(Shape::Sphere(Sphere::new(DVec3::new(0.0, 1.0, 0.0), 0.8)), glass, Vec3::ZERO)
//!     .source(SourceKind::Point { position: DVec3::new(2.0, 4.0, 0.0) }, LightStrength::Power(Vec3::splat(200.0)));
//! let camera = Camera::perspective(DVec3::new(0.0, 2.0, 6.0), DVec3::new(0.0, -0.2, -1.0), DVec3::Y, 0.7, 32, 24)?;
//! let scene = builder.build(camera)?;
//! let settings = Settings { caustic_photons: 2000, ..Settings::default() };
//! let pass = Algorithm::Hybrid.prepare(&scene, settings).pass(0, &Silent);
//! assert_eq!(pass.image.len(), 32 * 24);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
#![forbid(unsafe_code)]
#![warn(missing_docs)]

pub mod accel;
pub mod bsdf;
pub mod camera;
pub mod cli;
pub mod color;
pub mod format;
pub mod image;
pub mod integrate;
pub mod light;
pub mod math;
pub mod medium;
pub mod photon;
pub mod plan;
pub mod render;
pub mod sampling;
pub mod scene;
pub mod shape;
pub mod stats;
pub mod study;
pub mod texture;
