//! Converts the nodes of a glTF scene to objects, cameras and lights in world space.

use super::accessors::GltfBuffers;
use super::context::{FileContext, ReadResult};
use super::geometry::{mean_vertex_color, read_primitive};
use super::materials::GltfMaterials;
use crate::format::default_camera::{DEFAULT_ASPECT_RATIO, camera_with_aspect_ratio};
use crate::format::description::{
    CameraDescription, DirectionOrTarget, DirectionalLightDescription, DirectionalLightStrength, GroupItem,
    LightDescription, MeshDescription, MeshOptions, ObjectGroup, PointLightDescription, PointLightStrength,
    ProjectionDescription, ShapeDescription, Span, Spanned, SpotLightDescription,
};
use crate::format::import_notes::ImportNotes;
use crate::format::imported_objects::{extended_bounds, placed_object};
use crate::format::mesh::TriangleMesh;
use crate::math::Transform;
use glam::{DAffine3, DMat4, DQuat, DVec3};
use gltf::khr_lights_punctual::Kind;
use std::collections::{BTreeMap, HashMap};
use std::f64::consts::FRAC_PI_2;
use std::sync::Arc;

/// Luminous efficacy of radiation at 555 nm \[lm/W].
///
/// A file states intensities in candela and illuminances in lux. The importer divides both by this
/// constant, which gives W/sr and W/m².
const LUMENS_PER_WATT: f64 = 683.0;

/// Estimated memory of each instance of a primitive \[bytes], in the scene description and in the
/// built scene together.
const MEMORY_PER_INSTANCE: u64 = 1_500;

/// Objects, lights and camera that the nodes of a scene contain.
pub(super) struct GltfSceneContent {
    /// Objects of the imported scene with their materials, in the order of the nodes.
    pub root: ObjectGroup,
    /// Embedded meshes of the objects, by path.
    pub meshes: BTreeMap<String, Arc<TriangleMesh>>,
    /// Point, spot and directional lights.
    pub lights: Vec<Spanned<LightDescription>>,
    /// Camera of the first node that has one; `None` if no node has one.
    pub camera: Option<CameraDescription>,
    /// Lower and upper corner of the objects' bounds in world space; +∞ and −∞ if there are no
    /// objects.
    pub world_bounds: (DVec3, DVec3),
    /// True if at least one object of the scene has a material that emits light.
    pub has_emissive_surfaces: bool,
}

/// A glTF primitive after import: its mesh and its material.
#[derive(Clone)]
struct ImportedPrimitive {
    /// Path of the embedded mesh.
    mesh_path: String,
    /// Name of the material in the imported scene.
    material: String,
    /// Lower and upper corner of the mesh's bounds, in the space of the node.
    local_bounds: (DVec3, DVec3),
    /// True if the material emits light.
    emits: bool,
}

/// State of the walk through all nodes of a scene. It collects the content of the imported scene.
struct NodeWalker<'w, 'a> {
    context: &'a FileContext<'a>,
    buffers: &'a GltfBuffers<'a>,
    document: &'w gltf::Document,
    materials: &'w mut GltfMaterials<'a>,
    notes: &'w mut ImportNotes,
    /// Imported primitives. A key holds the index of the mesh in the file, and the index of the
    /// primitive in this mesh. A value is `None` for a primitive without triangles or with alpha 0
    /// everywhere.
    primitives: HashMap<(usize, usize), Option<ImportedPrimitive>>,
    content: GltfSceneContent,
}

/// Converts the nodes of one scene of the file: the default scene, or else the first scene.
///
/// If the file has no scene, converts all its nodes.
pub(super) fn read_scene<'a>(
    context: &'a FileContext<'a>,
    buffers: &'a GltfBuffers<'a>,
    document: &gltf::Document,
    materials: &mut GltfMaterials<'a>,
    notes: &mut ImportNotes,
) -> ReadResult<GltfSceneContent> {
    let content = GltfSceneContent {
        root: ObjectGroup::default(),
        meshes: BTreeMap::new(),
        lights: Vec::new(),
        camera: None,
        world_bounds: (DVec3::INFINITY, DVec3::NEG_INFINITY),
        has_emissive_surfaces: false,
    };
    let mut walker = NodeWalker { context, buffers, document, materials, notes, primitives: HashMap::new(), content };
    let nodes: Vec<gltf::Node<'_>> = document.nodes().collect();
    let roots: Vec<usize> = match document.default_scene().or_else(|| document.scenes().next()) {
        Some(scene) => {
            for other in document.scenes().filter(|other| other.index() != scene.index()) {
                walker.notes.add_unsupported("only the default scene is read", format!("scenes[{}]", other.index()));
            }
            scene.nodes().map(|node| node.index()).collect()
        }
        None => root_nodes(&nodes),
    };
    let mut is_visited = vec![false; nodes.len()];
    let mut open: Vec<(usize, DAffine3)> = roots.into_iter().rev().map(|root| (root, DAffine3::IDENTITY)).collect();
    while let Some((index, to_world)) = open.pop() {
        let node = &nodes[index];
        if std::mem::replace(&mut is_visited[index], true) {
            let message = "it is reached twice: the nodes of a scene must form trees";
            return Err(context.error(format!("nodes[{index}]"), message));
        }
        let to_world = to_world * local_transform(node);
        if !to_world.is_finite() {
            return Err(context.error(format!("nodes[{index}]"), "its transform is not finite"));
        }
        walker.add_node(node, to_world)?;
        let first = open.len();
        open.extend(node.children().map(|child| (child.index(), to_world)));
        open[first..].reverse();
    }
    Ok(walker.content)
}

/// Returns the indices of the nodes that are not a child of any node.
fn root_nodes(nodes: &[gltf::Node<'_>]) -> Vec<usize> {
    let mut is_child = vec![false; nodes.len()];
    for child in nodes.iter().flat_map(gltf::Node::children) {
        is_child[child.index()] = true;
    }
    (0..nodes.len()).filter(|i| !is_child[*i]).collect()
}

/// Returns the transform from a node to its parent node.
fn local_transform(node: &gltf::Node<'_>) -> DAffine3 {
    match node.transform() {
        gltf::scene::Transform::Matrix { matrix } => {
            DAffine3::from_mat4(DMat4::from_cols_array_2d(&matrix.map(|column| column.map(f64::from))))
        }
        gltf::scene::Transform::Decomposed { translation, rotation, scale } => trs_transform(
            DVec3::from(translation.map(f64::from)),
            rotation.map(f64::from),
            DVec3::from(scale.map(f64::from)),
        ),
    }
}

/// Returns the affine map of glTF's translation, rotation and scale: it scales first, then rotates,
/// then translates.
///
/// `rotation` is a quaternion x, y, z, w of any length. A length that is 0 or not finite stands for
/// no rotation.
fn trs_transform(translation: DVec3, rotation: [f64; 4], scale: DVec3) -> DAffine3 {
    let rotation = DQuat::from_array(rotation);
    let length = rotation.length();
    let rotation = if length > 0.0 && length.is_finite() { rotation / length } else { DQuat::IDENTITY };
    DAffine3::from_scale_rotation_translation(scale, rotation, translation)
}

impl NodeWalker<'_, '_> {
    /// Adds the objects, the camera and the light of a node to the content of the scene.
    ///
    /// `to_world` is the transform from the node to world space. A camera is ignored if an earlier
    /// node has one, and a message tells the user.
    fn add_node(&mut self, node: &gltf::Node<'_>, to_world: DAffine3) -> ReadResult<()> {
        let place = node_name(node);
        if node.skin().is_some() {
            self.notes.add_unsupported("skins are ignored: meshes have their rest pose", place.clone());
        }
        if let Some(mesh) = node.mesh() {
            if node.weights().or(mesh.weights()).is_some_and(|weights| weights.iter().any(|w| *w != 0.0)) {
                self.notes.add_unsupported("morph targets are ignored", place.clone());
            }
            let instances = self.instance_transforms(node)?;
            self.context.check_memory(MEMORY_PER_INSTANCE * (instances.len() * mesh.primitives().len()) as u64)?;
            for primitive in mesh.primitives() {
                let Some(imported) = self.import_primitive(&mesh, &primitive)? else { continue };
                for instance in &instances {
                    self.add_object(&imported, to_world * *instance, &place);
                }
            }
        }
        if let Some(camera) = node.camera() {
            if self.content.camera.is_some() {
                self.notes.add_unsupported("only the first camera is used", place);
            } else {
                self.content.camera = Some(self.camera_description(camera.index(), to_world)?);
            }
        }
        if let Some(light) = node.light() {
            self.add_light(&light, to_world)?;
        }
        Ok(())
    }

    /// Returns the transform of each instance of a node, from the space of the instance to the
    /// space of the node.
    ///
    /// The extension EXT_mesh_gpu_instancing states the instances. A node without it has one
    /// instance, with the identity as transform.
    fn instance_transforms(&mut self, node: &gltf::Node<'_>) -> ReadResult<Vec<DAffine3>> {
        let extension = node.extension_value("EXT_mesh_gpu_instancing");
        let Some(attributes) = extension.and_then(|value| value.get("attributes")) else {
            return Ok(vec![DAffine3::IDENTITY]);
        };
        let place = format!("nodes[{}].extensions.EXT_mesh_gpu_instancing", node.index());
        let accessor = |name: &str| -> ReadResult<Option<gltf::Accessor<'_>>> {
            let Some(index) = attributes.get(name) else { return Ok(None) };
            let found = index.as_u64().and_then(|i| self.document.accessors().nth(usize::try_from(i).ok()?));
            found.map(Some).ok_or_else(|| self.context.error(format!("{place}.{name}"), "an index out of range"))
        };
        let [translation, rotation, scale] = [accessor("TRANSLATION")?, accessor("ROTATION")?, accessor("SCALE")?];
        let vector_elements = |accessor: Option<gltf::Accessor<'_>>| -> ReadResult<Option<Vec<[f64; 3]>>> {
            accessor.map(|a| self.buffers.read_accessor(&a)?.vector_elements(self.context, &place)).transpose()
        };
        let (translations, scales) = (vector_elements(translation)?, vector_elements(scale)?);
        let rotations: Option<Vec<[f64; 4]>> =
            rotation.map(|a| self.buffers.read_accessor(&a)?.vector_elements(self.context, &place)).transpose()?;
        let counts =
            [translations.as_ref().map(Vec::len), rotations.as_ref().map(Vec::len), scales.as_ref().map(Vec::len)];
        let count = counts.into_iter().flatten().next().unwrap_or(0);
        if counts.into_iter().flatten().any(|other| other != count) {
            return Err(self.context.error(place, "its attributes have different numbers of elements"));
        }
        self.context.check_memory(MEMORY_PER_INSTANCE * count as u64)?;
        let transform = |i: usize| {
            trs_transform(
                translations.as_ref().map_or(DVec3::ZERO, |t| t[i].into()),
                rotations.as_ref().map_or([0.0, 0.0, 0.0, 1.0], |r| r[i]),
                scales.as_ref().map_or(DVec3::ONE, |s| s[i].into()),
            )
        };
        Ok((0..count).map(transform).collect())
    }

    /// Converts the mesh and the material of a primitive, unless an earlier call did.
    ///
    /// `None` if the primitive has no triangles, or if its alpha is 0 everywhere.
    fn import_primitive(
        &mut self,
        mesh: &gltf::Mesh<'_>,
        primitive: &gltf::Primitive<'_>,
    ) -> ReadResult<Option<ImportedPrimitive>> {
        let key = (mesh.index(), primitive.index());
        if let Some(known) = self.primitives.get(&key) {
            return Ok(known.clone());
        }
        let place = format!("meshes[{}].primitives[{}]", key.0, key.1);
        if primitive.extension_value("KHR_materials_variants").is_some() {
            self.notes.add_unsupported("variants are ignored: primitives have their default material", place.clone());
        }
        let color = mean_vertex_color(self.buffers, self.context, primitive, &place)?;
        if color.is_some() {
            self.notes.add_unsupported("vertex colors become their mean", place.clone());
        }
        let material = self.materials.imported_material(self.context, &primitive.material(), color, self.notes)?;
        let read = read_primitive(self.buffers, self.context, primitive, (&place, material.texcoord_set), self.notes)?;
        let imported = read.filter(|_| !material.is_invisible).map(|triangles| {
            let path = format!("mesh{}-{}", key.0, key.1);
            let start = (DVec3::INFINITY, DVec3::NEG_INFINITY);
            let bounds = triangles.positions.iter().fold(start, |(low, high), p| (low.min(*p), high.max(*p)));
            self.content.meshes.insert(path.clone(), Arc::new(triangles));
            ImportedPrimitive { mesh_path: path, material: material.name, local_bounds: bounds, emits: material.emits }
        });
        self.primitives.insert(key, imported.clone());
        Ok(imported)
    }

    /// Adds a primitive to the imported scene, with the transform `to_world`.
    ///
    /// If `to_world` is singular, adds only a note. The note calls the node `place`.
    fn add_object(&mut self, primitive: &ImportedPrimitive, to_world: DAffine3, place: &str) {
        if Transform::new(to_world).is_err() {
            self.notes.add_unsupported("objects that are scaled to nothing are left out", place);
            return;
        }
        let ImportedPrimitive { mesh_path: path, material, local_bounds, emits } = primitive;
        self.content.world_bounds = extended_bounds(Some(self.content.world_bounds), &to_world, *local_bounds);
        self.content.has_emissive_surfaces |= *emits;
        let path = Spanned::new(path.clone(), Span::default());
        let shape = ShapeDescription::Mesh(MeshDescription { path, options: MeshOptions::default() });
        let object = placed_object(shape, None, to_world);
        let material = Spanned::new(material.clone(), Span::default());
        let items = &mut self.content.root.items;
        items.push(GroupItem::MaterialName(material));
        items.push(GroupItem::Object(Spanned::new(object, Span::default())));
    }

    /// Converts the camera `index` of the file. It looks along −z of its node, with +y up.
    ///
    /// `to_world` is the transform of the node.
    fn camera_description(&self, index: usize, to_world: DAffine3) -> ReadResult<CameraDescription> {
        let place = format!("cameras[{index}]");
        let camera = &self.document.as_json().cameras[index];
        let invalid = |message: &str| self.context.error(&place, message);
        let (projection, aspect) = match (&camera.perspective, &camera.orthographic) {
            (Some(perspective), _) => {
                let angle = f64::from(perspective.yfov).to_degrees();
                if !(angle > 0.0 && angle < 180.0) {
                    return Err(invalid("its field of view is not between 0 and π"));
                }
                let aspect = perspective.aspect_ratio.map_or(DEFAULT_ASPECT_RATIO, f64::from);
                (ProjectionDescription::Perspective { vertical_fov_degrees: angle, lens: None }, aspect)
            }
            (None, Some(orthographic)) => {
                let (x, y) = (f64::from(orthographic.xmag).abs(), f64::from(orthographic.ymag).abs());
                if !(x > 0.0 && y > 0.0 && y <= 1e11) {
                    return Err(invalid("its magnification is 0 or too large"));
                }
                (ProjectionDescription::Orthographic { view_height: 2.0 * y }, x / y)
            }
            (None, None) => return Err(invalid("it has no projection")),
        };
        let (direction, up) = (-to_world.matrix3.z_axis, to_world.matrix3.y_axis);
        if Transform::new(to_world).is_err() {
            return Err(invalid("its node is scaled to nothing"));
        }
        Ok(camera_with_aspect_ratio(to_world.translation, direction.normalize(), up.normalize(), (projection, aspect)))
    }

    /// Converts and adds a light of the node whose transform is `to_world`.
    ///
    /// Spot and directional lights shine along −z of the node. Lights of intensity 0 are left out.
    fn add_light(&mut self, light: &gltf::khr_lights_punctual::Light<'_>, to_world: DAffine3) -> ReadResult<()> {
        let place = format!("extensions.KHR_lights_punctual.lights[{}]", light.index());
        let color = DVec3::from(light.color().map(f64::from));
        let strength = color * f64::from(light.intensity()) / LUMENS_PER_WATT;
        let position = to_world.translation;
        let direction = -to_world.matrix3.z_axis;
        if !(strength.is_finite() && strength.min_element() >= 0.0) {
            return Err(self.context.error(place, "its color or intensity is negative or not finite"));
        }
        if strength == DVec3::ZERO {
            return Ok(());
        }
        if light.range().is_some() {
            self.notes.add_unsupported("ranges of lights are ignored: light has no end", place.clone());
        }
        let is_directed = !matches!(light.kind(), Kind::Point);
        if is_directed && !(direction.length() > 0.0 && direction.is_finite()) {
            return Err(self.context.error(place, "its node is scaled to nothing"));
        }
        let aim = direction.normalize_or(DVec3::NEG_Z);
        let description = match light.kind() {
            Kind::Point => LightDescription::Point(PointLightDescription {
                position,
                strength: PointLightStrength::Intensity(strength),
            }),
            Kind::Directional => LightDescription::Directional(DirectionalLightDescription {
                direction: aim,
                strength: DirectionalLightStrength::Irradiance(strength),
            }),
            Kind::Spot { inner_cone_angle, outer_cone_angle } => {
                let (inner, outer) = (f64::from(inner_cone_angle), f64::from(outer_cone_angle));
                if !(outer > 0.0 && outer <= FRAC_PI_2 + 1e-6 && inner >= 0.0 && inner <= outer) {
                    let message =
                        "its angles are not 0 ≤ innerConeAngle ≤ outerConeAngle ≤ π/2 with an outer one above 0";
                    return Err(self.context.error(place, message));
                }
                let angle = 2.0 * outer.to_degrees();
                let penumbra = (outer - inner).to_degrees().min(0.5 * angle);
                let aim = DirectionOrTarget::Direction(aim);
                LightDescription::Spot(SpotLightDescription {
                    position,
                    aim,
                    full_cone_angle_degrees: angle,
                    penumbra_degrees: penumbra,
                    strength: PointLightStrength::Intensity(strength),
                })
            }
        };
        self.content.lights.push(Spanned::new(description, Span::default()));
        Ok(())
    }
}

/// Returns the name of a node for messages.
fn node_name(node: &gltf::Node<'_>) -> String {
    node.name().map_or_else(|| format!("nodes[{}]", node.index()), |name| format!("node `{name}`"))
}
