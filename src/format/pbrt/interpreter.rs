//! Interprets the directives of a pbrt scene file, in order, and collects the imported scene.

mod shape_directive;

use super::camera::{FilmSize, film_size, note_exposure_time, read_camera, shutter_times};
use super::content::PbrtSceneContent;
use super::files::{PbrtSceneFiles, PbrtSourceLocation, ReadResult};
use super::graphics_state::{
    AreaLightDirective, GraphicsState, MaterialReference, MovingTransform, directive_transform,
};
use super::lights::PbrtLights;
use super::materials::PbrtMaterials;
use super::media::PbrtMedia;
use super::objects::{PbrtObjects, PbrtPlacement};
use super::parameters::{Parameters, read_numbers, read_quoted};
use super::settings::SuggestedFlags;
use super::textures::PbrtTextures;
use super::tokens::{PbrtToken, TokenKind, Tokenizer};
use crate::format::SourceText;
use crate::format::assets::EmbeddedAssets;
use crate::format::description::{
    CameraDescription, DirectionOrTarget, EnvironmentRadiance, LightDescription, ProjectionDescription,
    SceneDescription, Span, Spanned,
};
use crate::format::import::ImportedScene;
use crate::format::import_notes::ImportNotes;
use glam::{DAffine3, DVec3};
use std::collections::{BTreeMap, HashMap};
use std::rc::Rc;

/// Greatest depth of nested includes.
const MAX_INCLUDE_DEPTH: usize = 32;

/// Greatest number of included files.
const MAX_INCLUDES: usize = 100_000;

/// Greatest number of graphics states that the open blocks of a file can save at one time.
const MAX_SAVED_STATES: usize = 10_000;

/// Estimated memory of each saved graphics state \[bytes].
const MEMORY_PER_STATE: u64 = 600;

/// Directives that set how pbrt renders or stores pictures. They do not change the imported scene,
/// but some of them become suggested flags of `caustica render`.
const RENDER_SETTING_DIRECTIVES: [&str; 8] = [
    "Accelerator",
    "ColorSpace",
    "Integrator",
    "PixelFilter",
    "Renderer",
    "Sampler",
    "SurfaceIntegrator",
    "VolumeIntegrator",
];

/// Interpreter of a pbrt scene: pbrt's graphics state, and the imported scene so far.
pub(super) struct Interpreter<'a> {
    files: &'a PbrtSceneFiles<'a>,
    /// Current graphics state.
    state: GraphicsState,
    /// Graphics states of the open attribute, transform and object blocks, the innermost last.
    saved: Vec<GraphicsState>,
    /// Coordinate systems by name: those of `CoordinateSystem` directives, and pbrt's predefined
    /// `world` and `camera`.
    coordinate_systems: HashMap<String, MovingTransform>,
    content: PbrtSceneContent,
    lights: PbrtLights,
    media: PbrtMedia,
    film_size: Option<FilmSize>,
    settings: SuggestedFlags,
    camera: Option<CameraDescription>,
    /// Name of the medium around the camera; empty for vacuum.
    ambient_medium: Rc<str>,
    /// Map from pbrt's world to the imported scene: a reflection along z or the identity, so that
    /// the camera shows pbrt's picture and not its mirror image.
    mirror: DAffine3,
    /// Parameters, kind and camera-to-world transform of a `Camera` directive, until `WorldBegin`
    /// makes the camera; `None` afterwards.
    ///
    /// The camera needs the film, which may follow the `Camera` directive.
    camera_directive: Option<(Rc<Parameters>, String, MovingTransform)>,
    /// Start and end of the motion of objects (`TransformTimes`): the times at which a moving
    /// object has its first and its second transform.
    transform_times: [f64; 2],
    /// Times at which the shutter opens and closes.
    shutter_times: [f64; 2],
    objects: PbrtObjects,
    include_count: usize,
    shape_count: usize,
}

impl<'a> Interpreter<'a> {
    /// Returns an interpreter that has read no directive.
    pub fn new(files: &'a PbrtSceneFiles<'a>) -> Self {
        let content = PbrtSceneContent {
            meshes: BTreeMap::new(),
            textures: PbrtTextures::default(),
            materials: PbrtMaterials::new(),
            notes: ImportNotes::default(),
            is_v3: false,
        };
        Self {
            files,
            state: GraphicsState::new(),
            saved: Vec::new(),
            coordinate_systems: HashMap::from([("world".to_owned(), MovingTransform::IDENTITY)]),
            content,
            lights: PbrtLights::default(),
            media: PbrtMedia::default(),
            film_size: None,
            settings: SuggestedFlags::default(),
            camera: None,
            ambient_medium: "".into(),
            mirror: DAffine3::from_scale(DVec3::new(1.0, 1.0, -1.0)),
            camera_directive: None,
            transform_times: [0.0, 1.0],
            shutter_times: [0.0, 1.0],
            objects: PbrtObjects::default(),
            include_count: 0,
            shape_count: 0,
        }
    }

    /// Executes all directives of the scene file, whose content is `bytes`.
    pub fn run(&mut self, bytes: &[u8]) -> ReadResult<()> {
        let file: Rc<str> = self.files.path.display().to_string().into();
        self.run_file(bytes, file, 0)?;
        if self.camera.is_none() {
            self.place_camera()?;
        }
        Ok(())
    }

    /// Returns the imported scene. Adds a white sky if nothing emits light, and a camera if the
    /// file has none.
    pub fn finish(mut self) -> ReadResult<ImportedScene> {
        let place = PbrtSourceLocation { file: self.files.path.display().to_string().into(), line: 1 };
        if self.objects.has_open_definition() {
            return Err(place.error("an object is not closed", "add `ObjectEnd`"));
        }
        let has_emitters = self.lights.has_emissive_surfaces;
        let mut lights = self.lights.into_descriptions(&mut self.content, self.files)?;
        if lights.is_empty() && !has_emitters {
            self.content.notes.add_missing("the file has no light: a white sky of radiance 1 lights the scene");
            let sky = LightDescription::Environment(EnvironmentRadiance::Constant(DVec3::ONE));
            lights.push(Spanned::new(sky, Span::default()));
        }
        let camera = self.camera.unwrap_or_else(|| {
            self.content.notes.add_missing("the file has no camera: it stands at the origin, and looks along z");
            CameraDescription {
                center: DVec3::ZERO,
                aim: DirectionOrTarget::Direction(self.mirror.transform_vector3(DVec3::Z)),
                up: DVec3::Y,
                projection: ProjectionDescription::Perspective { vertical_fov_degrees: 90.0, lens: None },
                width: 640,
                height: 480,
                motion: Vec::new(),
            }
        });
        let ambient_medium =
            (!self.ambient_medium.is_empty()).then(|| Spanned::new(self.ambient_medium.to_string(), Span::default()));
        let flags = self.settings.flags_text();
        if !flags.is_empty() {
            let message = format!("the settings of the file are not applied: they stand for `{flags}`");
            self.content.notes.add_missing(&message);
        }
        let PbrtSceneContent { meshes, textures, materials, notes, .. } = self.content;
        let (media, grids) = self.media.into_descriptions(self.mirror);
        let description = SceneDescription {
            camera: Spanned::new(camera, Span::default()),
            background: DVec3::ZERO,
            ambient_medium,
            lights,
            textures: textures.descriptions,
            media,
            materials: materials.descriptions,
            root: self.objects.into_root(),
        };
        let assets = EmbeddedAssets { meshes, pictures: textures.pictures, grids };
        let source = SourceText::new(&self.files.path.display().to_string(), "");
        Ok(ImportedScene { description, source, assets, notes: notes.into_notes() })
    }

    /// Executes the directives of one file, and of the files that it includes.
    ///
    /// `depth` is the number of files that include this one, directly or indirectly.
    fn run_file(&mut self, bytes: &[u8], file: Rc<str>, depth: usize) -> ReadResult<()> {
        let text = String::from_utf8_lossy(bytes);
        let text = text.strip_prefix('\u{feff}').unwrap_or(&text);
        let mut tokens = Tokenizer::new(text, file);
        while let Some(token) = tokens.next_token()? {
            let place = tokens.place(token.line);
            let TokenKind::Unquoted(directive) = token.kind else {
                return Err(place.error("a value stands outside of a directive", "begin with a directive, as `Shape`"));
            };
            self.run_directive(directive, &mut tokens, place, depth)?;
        }
        Ok(())
    }

    /// Reads the arguments of one directive from `tokens`, and executes it.
    fn run_directive(
        &mut self,
        directive: &str,
        tokens: &mut Tokenizer<'_>,
        place: PbrtSourceLocation,
        depth: usize,
    ) -> ReadResult<()> {
        match directive {
            "Translate" | "Scale" | "Rotate" | "LookAt" | "Transform" | "ConcatTransform" => {
                let count = match directive {
                    "Translate" | "Scale" => 3,
                    "Rotate" => 4,
                    "LookAt" => 9,
                    _ => 16,
                };
                let map = directive_transform(directive, &read_numbers(tokens, count, &place)?, &place)?;
                if directive == "Transform" {
                    self.state.set_transform(MovingTransform::IDENTITY);
                }
                self.state.concatenate(map, &place)
            }
            "Identity" => {
                self.state.set_transform(MovingTransform::IDENTITY);
                Ok(())
            }
            "TransformTimes" => {
                let times = read_numbers(tokens, 2, &place)?;
                self.transform_times = [times[0], times[1]];
                Ok(())
            }
            "Option" => {
                // Skip the value, which is one word or quoted text.
                read_quoted(tokens, &place)?;
                tokens.next_token()?;
                Ok(())
            }
            "CoordinateSystem" => {
                let name = read_quoted(tokens, &place)?;
                self.files.reserve_memory(MEMORY_PER_STATE)?;
                self.coordinate_systems.insert(name, self.state.transform);
                Ok(())
            }
            "CoordSysTransform" => {
                let name = read_quoted(tokens, &place)?;
                let known = self.coordinate_systems.get(&name).copied();
                let transform = known.ok_or_else(|| {
                    let help = "define it with `CoordinateSystem`; `camera` needs a camera before";
                    place.error(format!("no coordinate system is called `{name}`"), help)
                })?;
                self.state.set_transform(transform);
                Ok(())
            }
            "ActiveTransform" => {
                let word = match tokens.next_token()? {
                    Some(PbrtToken { kind: TokenKind::Unquoted(word), .. }) => word,
                    _ => "",
                };
                self.state.is_transform_active = match word {
                    "All" => [true; 2],
                    "StartTime" => [true, false],
                    "EndTime" => [false, true],
                    _ => return Err(place.error("`ActiveTransform` needs All, StartTime or EndTime", "add the word")),
                };
                Ok(())
            }
            "ReverseOrientation" => {
                self.state.is_reversed = !self.state.is_reversed;
                Ok(())
            }
            "AttributeBegin" | "TransformBegin" => self.save_state(&place),
            "AttributeEnd" | "TransformEnd" => {
                let saved = self.saved.pop().ok_or_else(|| {
                    place.error(format!("`{directive}` without a begin"), "remove it, or add the begin")
                })?;
                if directive == "AttributeEnd" {
                    self.content.materials.restore_names(saved.named_definition_count);
                    self.state = saved;
                } else {
                    (self.state.transform, self.state.is_transform_active) =
                        (saved.transform, saved.is_transform_active);
                }
                Ok(())
            }
            "WorldBegin" => {
                self.place_camera()?;
                self.state.transform = MovingTransform::IDENTITY;
                self.state.is_transform_active = [true; 2];
                Ok(())
            }
            "WorldEnd" => Ok(()),
            "ObjectBegin" => {
                let name = read_quoted(tokens, &place)?;
                if self.objects.has_open_definition() {
                    return Err(place.error("an object is defined inside an object", "close the first: `ObjectEnd`"));
                }
                self.save_state(&place)?;
                self.objects.begin_definition(name);
                Ok(())
            }
            "ObjectEnd" => {
                let without = || place.error("`ObjectEnd` without `ObjectBegin`", "remove it");
                self.objects.end_definition().ok_or_else(without)?;
                self.state = self.saved.pop().ok_or_else(without)?;
                self.content.materials.restore_names(self.state.named_definition_count);
                Ok(())
            }
            "ObjectInstance" => {
                let name = read_quoted(tokens, &place)?;
                let placement =
                    PbrtPlacement { mirror: self.mirror, transform: self.transform_over_shutter(), place: &place };
                self.objects.add_instance(&name, &placement, self.files, &mut self.content.notes)
            }
            "Include" | "Import" => {
                let name = read_quoted(tokens, &place)?;
                self.run_included_file(&name, directive == "Import", &place, depth)
            }
            "MediumInterface" => {
                let inside = read_quoted(tokens, &place)?;
                let outside = match tokens.peek_token()? {
                    Some(PbrtToken { kind: TokenKind::Quoted(_), .. }) => read_quoted(tokens, &place)?,
                    _ => inside.clone(),
                };
                self.state.medium_interface = [inside.into(), outside.into()];
                Ok(())
            }
            "NamedMaterial" => {
                let name = read_quoted(tokens, &place)?;
                self.state.material = self.content.materials.reference(name, place);
                Ok(())
            }
            "Texture" => {
                let (name, value_kind, class) =
                    (read_quoted(tokens, &place)?, read_quoted(tokens, &place)?, read_quoted(tokens, &place)?);
                let parameters = Parameters::read(tokens, place, self.files)?;
                let PbrtSceneContent { textures, notes, is_v3, .. } = &mut self.content;
                let is_color = value_kind != "float";
                textures.define_texture((&name, &class, is_color), &parameters, *is_v3, self.files, notes)
            }
            _ => {
                let known = RENDER_SETTING_DIRECTIVES.contains(&directive)
                    || matches!(
                        directive,
                        "Camera"
                            | "Film"
                            | "Attribute"
                            | "MakeNamedMaterial"
                            | "MakeNamedMedium"
                            | "Material"
                            | "LightSource"
                            | "AreaLightSource"
                            | "Shape"
                    );
                if !known {
                    let message = format!("`{directive}` is not a directive of pbrt");
                    return Err(place.error(message, "correct its spelling; a directive ends where its file ends"));
                }
                let name = read_quoted(tokens, &place)?;
                let parameters = Parameters::read(tokens, place, self.files)?;
                self.run_parametrized_directive(directive, &name, parameters)
            }
        }
    }

    /// Executes a directive with a name and a parameter list, such as `Shape "sphere" …`.
    fn run_parametrized_directive(&mut self, directive: &str, name: &str, parameters: Parameters) -> ReadResult<()> {
        let place = parameters.place.clone();
        match directive {
            "Film" => {
                self.content.is_v3 |= name == "image";
                self.film_size = Some(film_size(name, &parameters, &mut self.content.notes)?);
                Ok(())
            }
            "Camera" => {
                let to_world = self.state.transform.inverse();
                let to_world =
                    to_world.ok_or_else(|| place.error("the camera's transform is singular", "scale less"))?;
                self.coordinate_systems.insert("camera".to_owned(), to_world);
                self.ambient_medium = Rc::clone(&self.state.medium_interface[1]);
                self.shutter_times = shutter_times(&parameters);
                self.camera_directive = Some((Rc::new(parameters), name.to_owned(), to_world));
                Ok(())
            }
            "Attribute" => {
                let message = "parameters by `Attribute` are ignored";
                self.content.notes.add_unsupported(message, place.position_text());
                Ok(())
            }
            "Material" => {
                let number = self.content.materials.add_numbered(name, parameters);
                self.state.material = MaterialReference::Numbered(number);
                Ok(())
            }
            "MakeNamedMaterial" => self.content.materials.add_named(name, parameters, self.content.is_v3),
            "MakeNamedMedium" => {
                let (to_world, notes) = (self.transform_over_shutter().0[0], &mut self.content.notes);
                self.media.add_medium(name, &parameters, to_world, self.files, notes)
            }
            "LightSource" => {
                let transform = self.transform_over_shutter();
                if !transform.is_still() {
                    let message = "lights that move stay where they are when the shutter opens";
                    self.content.notes.add_unsupported(message, place.position_text());
                }
                let mirrored = self.mirror * transform.0[0];
                self.lights.add_light(name, &parameters, mirrored, &mut self.content, self.files)
            }
            "AreaLightSource" => {
                if !matches!(name, "diffuse" | "area") {
                    let message = format!("no area light is called `{name}`");
                    return Err(place.error(message, "pbrt has area lights `diffuse`"));
                }
                self.state.area_light = Some(AreaLightDirective { parameters: Rc::new(parameters) });
                Ok(())
            }
            "Shape" => self.add_shape(name, &parameters),
            "ColorSpace" if !name.eq_ignore_ascii_case("srgb") => {
                let message = "colors of other color spaces count as sRGB";
                self.content.notes.add_unsupported(message, place.position_text());
                Ok(())
            }
            // All other directives are settings of the renderer, which become suggested flags.
            _ => {
                self.settings.add_directive(directive, name, &parameters);
                Ok(())
            }
        }
    }

    /// Saves the graphics state at the start of a block.
    fn save_state(&mut self, place: &PbrtSourceLocation) -> ReadResult<()> {
        if self.saved.len() >= MAX_SAVED_STATES {
            return Err(place.error("attribute blocks nest too deep", "close the blocks: `AttributeEnd`"));
        }
        self.files.reserve_memory(MEMORY_PER_STATE)?;
        let named_definition_count = self.content.materials.named_definition_count();
        self.saved.push(GraphicsState { named_definition_count, ..self.state.clone() });
        Ok(())
    }

    /// Returns the times at which the shutter opens and closes, as fractions of the time in which
    /// objects move. An object has its first transform at fraction 0, and its second at fraction 1.
    fn shutter_fractions(&self) -> [f64; 2] {
        let [start, end] = self.transform_times;
        if start < end { self.shutter_times.map(|time| (time - start) / (end - start)) } else { [0.0, 1.0] }
    }

    /// Returns the current object-to-world transforms at the opening and closing of the shutter.
    fn transform_over_shutter(&self) -> MovingTransform {
        self.state.transform.at_fractions(self.shutter_fractions())
    }

    /// Makes the camera from the last `Camera` directive, and sets `mirror`.
    ///
    /// Does nothing if the file had no `Camera` directive, or if an earlier call has made its
    /// camera.
    fn place_camera(&mut self) -> ReadResult<()> {
        let Some((parameters, name, to_world)) = self.camera_directive.take() else { return Ok(()) };
        let size = self.film_size.unwrap_or(FilmSize::DEFAULT);
        let to_world = to_world.at_fractions(self.shutter_fractions());
        if !self.content.is_v3 {
            note_exposure_time(&parameters, &mut self.content.notes);
        }
        let (camera, mirror) = read_camera(&name, &parameters, to_world, size, &mut self.content.notes)?;
        self.camera = Some(camera);
        self.mirror = mirror;
        Ok(())
    }

    /// Executes the directives of the file `name`, for `Include` or `Import`.
    fn run_included_file(
        &mut self,
        name: &str,
        is_import: bool,
        place: &PbrtSourceLocation,
        depth: usize,
    ) -> ReadResult<()> {
        self.include_count += 1;
        if depth >= MAX_INCLUDE_DEPTH || self.include_count > MAX_INCLUDES {
            let help = "let no file include itself";
            return Err(place.error(format!("files include each other too often, last `{name}`"), help));
        }
        let path = self.files.resolve_path(place, name)?;
        let bytes = self.files.read_file(&path)?;
        let bytes = if name.ends_with(".gz") { self.files.gunzipped(&bytes, place)? } else { bytes };
        // An imported file does not change the graphics state of the file that imports it.
        let saved = is_import.then(|| self.state.clone());
        self.run_file(&bytes, path.display().to_string().into(), depth + 1)?;
        if let Some(saved) = saved {
            self.state = saved;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests;
