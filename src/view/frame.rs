//! Pixels that the live page shows: the picture, its light groups, maps of its estimated error, and
//! surface AOVs.

use crate::image::Image;
use crate::integrate::{LightGroup, MeanGatherDisc, SurfaceAovs};
use crate::render::error_estimate::{ErrorMaps, MIN_ERROR_ESTIMATE_PASSES};
use crate::render::{Film, RenderResult};
use axum::body::Bytes;
use glam::{Vec2, Vec3};
use half::f16;
use half::slice::HalfFloatSliceExt;
use std::sync::OnceLock;

/// Number of bytes of the header before the pixel values in the encoding of a [`Layer`].
pub(super) const HEADER_BYTES: usize = 20;

/// Binary exponent e: layers are scaled so that the absolute values of half floats stay below 2ᵉ.
///
/// Half floats can hold values below 2¹⁶, so 15 leaves a factor of 2. Half floats below 2⁻¹⁴ are
/// subnormal and lose digits.
const MAX_EXPONENT: i32 = 15;

/// Number of channel values that are converted to half floats at once.
const CHUNK: usize = 1024;

enum_with_all! {
    /// Kind of layer that the live page can show.
    #[derive(Clone, Copy, Debug, PartialEq, Eq)]
    pub enum LayerKind {
        /// The picture: radiance \[W/(m² sr)].
        Picture,
        /// Direct light of the picture \[W/(m² sr)], see [`LightGroup::Direct`].
        Direct,
        /// Indirect light of the picture \[W/(m² sr)], see [`LightGroup::Indirect`].
        Indirect,
        /// Caustic light of the picture \[W/(m² sr)], see [`LightGroup::Caustic`].
        Caustic,
        /// Noise: standard error of the picture, which is the mean of all passes \[W/(m² sr)].
        Noise,
        /// Estimated bias \[W/(m² sr)]: the blur of photon density estimates. Values are positive
        /// where the picture is too bright.
        Bias,
        /// Mean gather radius of density estimates with photons of caustics \[length].
        CausticRadius,
        /// Mean gather radius of density estimates with photons of all light except caustics
        /// \[length].
        IndirectRadius,
        /// Mean number of photons in a density estimate of caustics.
        CausticPhotons,
        /// Mean number of photons in a density estimate of all light except caustics.
        IndirectPhotons,
        /// Albedo of the visible surface, in \[0, 1]. Like all surface AOVs, it describes the first
        /// surface that is not specular: rays continue at mirrors and smooth glass.
        Albedo,
        /// Shading normal of the visible surface, in world space.
        Normal,
        /// Length of the path from the camera to the visible surface, through mirrors and smooth
        /// glass \[length].
        Depth,
        /// Position of the visible surface in world space \[length].
        Position,
        /// Number of the visible object, counted from 1; 0 where no object is visible.
        Object,
        /// Number of the visible material, counted from 1; 0 where no surface is visible.
        Material,
        /// Motion of the visible surface on the film while the shutter is open \[pixels; x to the
        /// right, y down].
        Motion,
    }
}

/// Kind of [`LiveFrame`]: a group of layers that are published together.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum FrameKind {
    /// The picture and its light groups: direct, indirect and caustic light.
    Picture,
    /// Maps of the estimated error: noise, bias, gather radii and photon counts.
    ErrorMaps,
    /// Surface AOVs (data of the surface that each pixel shows), such as albedo, normal and depth.
    SurfaceAovs,
}

impl LayerKind {
    /// Returns the name of the layer in the URL of its pixels: `picture`, or the name that the
    /// layer has in an EXR file with `--aov`, such as `radius.caustic`.
    #[must_use]
    pub fn url_name(self) -> &'static str {
        match self {
            Self::Picture => "picture",
            Self::Direct => LightGroup::Direct.name(),
            Self::Indirect => LightGroup::Indirect.name(),
            Self::Caustic => LightGroup::Caustic.name(),
            Self::Noise => "noise",
            Self::Bias => "bias",
            Self::CausticRadius => "radius.caustic",
            Self::IndirectRadius => "radius.global",
            Self::CausticPhotons => "photons.caustic",
            Self::IndirectPhotons => "photons.global",
            Self::Albedo => "albedo",
            Self::Normal => "normal",
            Self::Depth => "depth",
            Self::Position => "position",
            Self::Object => "object",
            Self::Material => "material",
            Self::Motion => "motion",
        }
    }

    /// Returns the kind of frame in which a layer of this kind is published.
    pub(super) fn frame_kind(self) -> FrameKind {
        match self {
            Self::Picture | Self::Direct | Self::Indirect | Self::Caustic => FrameKind::Picture,
            Self::Noise
            | Self::Bias
            | Self::CausticRadius
            | Self::IndirectRadius
            | Self::CausticPhotons
            | Self::IndirectPhotons => FrameKind::ErrorMaps,
            Self::Albedo
            | Self::Normal
            | Self::Depth
            | Self::Position
            | Self::Object
            | Self::Material
            | Self::Motion => FrameKind::SurfaceAovs,
        }
    }

    /// Returns the kind of the layer that shows a light group.
    fn of_light_group(group: LightGroup) -> Self {
        match group {
            LightGroup::Direct => Self::Direct,
            LightGroup::Indirect => Self::Indirect,
            LightGroup::Caustic => Self::Caustic,
        }
    }

    /// True for layers of object or material numbers. They are encoded as 32-bit floats, because
    /// half floats round numbers above 2048.
    fn has_identifiers(self) -> bool {
        matches!(self, Self::Object | Self::Material)
    }

    /// Returns the kind whose [`url_name`](Self::url_name) is `name`; `None` if there is no such
    /// kind.
    #[must_use]
    pub fn from_url_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|kind| kind.url_name() == name)
    }
}

/// Pixels of one layer of a frame. The pixels are encoded for browsers at the first request, and
/// the result is kept for later requests.
#[derive(Debug)]
pub struct Layer {
    /// Kind of layer.
    pub kind: LayerKind,
    /// Number of channels, from 1 to 3.
    channels: u32,
    /// Channel values of all pixels, in rows from the top. The channels of a pixel are adjacent.
    values: Vec<f32>,
    /// Bytes of [`LiveFrame::encoded_layer`]; empty until a browser first asks for them.
    encoded: OnceLock<Bytes>,
}

/// Layers of equal size that are published together: the picture of a render with its light groups
/// (direct, indirect and caustic light), maps of its estimated error, or surface AOVs.
#[derive(Debug)]
pub struct LiveFrame {
    /// Sequence number of the page update that delivered the frame. Later frames have larger
    /// numbers.
    pub sequence: u32,
    /// Width and height \[pixels].
    pub size: (u32, u32),
    /// Number of passes from which the layers were computed; 0 for a preview.
    pub passes: u32,
    /// True if the frame shows a preview of reduced size.
    pub is_preview: bool,
    /// The layers: the picture with its light groups, error maps, or surface AOVs.
    pub layers: Vec<Layer>,
}

impl Layer {
    /// Makes a layer with three channels from RGB colours.
    #[must_use]
    pub fn from_colors(kind: LayerKind, pixels: &[Vec3]) -> Self {
        let values = pixels.iter().flat_map(|pixel| pixel.to_array()).collect();
        Self { kind, channels: 3, values, encoded: OnceLock::new() }
    }

    /// Makes a layer with one channel from numbers.
    #[must_use]
    pub fn from_numbers(kind: LayerKind, values: Vec<f32>) -> Self {
        Self { kind, channels: 1, values, encoded: OnceLock::new() }
    }

    /// Makes a layer with two channels from 2D vectors on the film.
    #[must_use]
    pub fn from_film_vectors(kind: LayerKind, vectors: &[Vec2]) -> Self {
        let values = vectors.iter().flat_map(|vector| vector.to_array()).collect();
        Self { kind, channels: 2, values, encoded: OnceLock::new() }
    }

    /// Returns the RGB colours of a layer with three channels.
    #[must_use]
    pub fn colors(&self) -> Vec<Vec3> {
        self.values.as_chunks().0.iter().map(|channels| Vec3::from_array(*channels)).collect()
    }
}

impl LiveFrame {
    /// Makes a frame that holds the picture alone.
    #[must_use]
    pub fn from_picture(sequence: u32, size: (u32, u32), passes: u32, pixels: &[Vec3]) -> Self {
        let layers = vec![Layer::from_colors(LayerKind::Picture, pixels)];
        Self { sequence, size, passes, is_preview: false, layers }
    }

    /// Makes a frame of the picture of `rendered`, and of its light groups if it has them.
    #[must_use]
    pub fn from_render(sequence: u32, rendered: &RenderResult) -> Self {
        let film = &rendered.film;
        let mut frame = Self::from_picture(sequence, film.size(), film.passes(), &film.mean_picture());
        let groups = LightGroup::ALL.iter().zip(&rendered.light_group_films);
        let layer = |(group, film): (&LightGroup, &Film)| {
            Layer::from_colors(LayerKind::of_light_group(*group), &film.mean_picture())
        };
        frame.layers.extend(groups.map(layer));
        frame
    }

    /// Makes a frame of surface AOVs of a picture of `size` (width, height) pixels.
    #[must_use]
    pub fn from_surface_aovs(sequence: u32, size: (u32, u32), aovs: &SurfaceAovs) -> Self {
        let identifiers = |values: &[u32]| values.iter().map(|id| *id as f32).collect();
        let layers = vec![
            Layer::from_colors(LayerKind::Albedo, &aovs.albedo),
            Layer::from_colors(LayerKind::Normal, &aovs.normal),
            Layer::from_numbers(LayerKind::Depth, aovs.depth.clone()),
            Layer::from_colors(LayerKind::Position, &aovs.position),
            Layer::from_numbers(LayerKind::Object, identifiers(&aovs.object_id)),
            Layer::from_numbers(LayerKind::Material, identifiers(&aovs.material_id)),
            Layer::from_film_vectors(LayerKind::Motion, &aovs.motion),
        ];
        Self { sequence, size, passes: 0, is_preview: false, layers }
    }

    /// Makes a frame of an image that no render made, such as the reference picture.
    #[must_use]
    pub fn from_image(image: &Image) -> Self {
        Self::from_picture(0, (image.width(), image.height()), 0, image.pixels())
    }

    /// Makes a frame of the maps of the estimated error. `None` if the render does not estimate
    /// errors, or has made fewer than [`MIN_ERROR_ESTIMATE_PASSES`] passes.
    #[must_use]
    pub fn from_error_maps(sequence: u32, rendered: &RenderResult) -> Option<Self> {
        let estimator = rendered.estimator.as_ref().filter(|_| rendered.film.passes() >= MIN_ERROR_ESTIMATE_PASSES)?;
        let ErrorMaps { noise, blur: bias, caustic_discs, indirect_discs } = estimator.error_maps(&rendered.film);
        let mut layers = vec![Layer::from_colors(LayerKind::Noise, &noise)];
        if !bias.is_empty() {
            let numbers = |kind, discs: &[MeanGatherDisc], value: fn(&MeanGatherDisc) -> f32| {
                Layer::from_numbers(kind, discs.iter().map(value).collect())
            };
            layers.push(Layer::from_colors(LayerKind::Bias, &bias));
            layers.push(numbers(LayerKind::CausticRadius, &caustic_discs, |disc| disc.radius));
            layers.push(numbers(LayerKind::IndirectRadius, &indirect_discs, |disc| disc.radius));
            layers.push(numbers(LayerKind::CausticPhotons, &caustic_discs, |disc| disc.mean_count));
            layers.push(numbers(LayerKind::IndirectPhotons, &indirect_discs, |disc| disc.mean_count));
        }
        let (size, passes) = (rendered.film.size(), rendered.film.passes());
        Some(Self { sequence, size, passes, is_preview: false, layers })
    }

    /// Returns the layer of the given kind; `None` if the frame lacks it.
    #[must_use]
    pub fn layer(&self, kind: LayerKind) -> Option<&Layer> {
        self.layers.iter().find(|layer| layer.kind == kind)
    }

    /// Returns the bytes that encode a layer for a browser; `None` if the frame lacks the layer.
    ///
    /// The header has four 32-bit integers (sequence number, width, height and number of channels)
    /// and a 32-bit float, the scale. The pixel values follow as half floats, divided by the scale.
    /// Object and material numbers are 32-bit floats instead, and their scale is 1. All numbers are
    /// little-endian.
    #[must_use]
    pub fn encoded_layer(&self, kind: LayerKind) -> Option<Bytes> {
        let layer = self.layer(kind)?;
        let encode = || {
            let (width, height) = self.size;
            let has_identifiers = kind.has_identifiers();
            let (scale, value_bytes) = if has_identifiers { (1.0, 4) } else { (layer_scale(&layer.values), 2) };
            let mut bytes = Vec::with_capacity(HEADER_BYTES + value_bytes * layer.values.len());
            for number in [self.sequence, width, height, layer.channels, scale.to_bits()] {
                bytes.extend_from_slice(&number.to_le_bytes());
            }
            if has_identifiers {
                layer.values.iter().for_each(|value| bytes.extend_from_slice(&value.to_le_bytes()));
                return Bytes::from(bytes);
            }
            let (mut scaled, mut halves) = ([0.0; CHUNK], [f16::ZERO; CHUNK]);
            for chunk in layer.values.chunks(CHUNK) {
                let (scaled, halves) = (&mut scaled[..chunk.len()], &mut halves[..chunk.len()]);
                scaled.iter_mut().zip(chunk).for_each(|(scaled, value)| *scaled = value / scale);
                halves.convert_from_f32_slice(scaled);
                halves.iter().for_each(|half| bytes.extend_from_slice(&half.to_le_bytes()));
            }
            Bytes::from(bytes)
        };
        Some(layer.encoded.get_or_init(encode).clone())
    }
}

/// Returns the scale, a power of two, by which `values` are divided before they become half floats.
///
/// The largest finite absolute value is scaled to \[2¹⁴, 2¹⁵), or to less if all values are tiny.
/// So values down to 2⁻²⁸ of the largest one keep all 11 bits of a half float. The scale is 1 if
/// all values are below 2⁻¹²⁶ (zero or subnormal).
fn layer_scale(values: &[f32]) -> f32 {
    let largest = values.iter().filter(|value| value.is_finite()).fold(0.0_f32, |largest, v| largest.max(v.abs()));
    if largest < f32::MIN_POSITIVE {
        return 1.0;
    }
    let (_, exponent) = libm::frexpf(largest);
    // The scale and its inverse must be normal numbers.
    libm::ldexpf(1.0, (exponent - MAX_EXPONENT).clamp(-126, 126))
}
