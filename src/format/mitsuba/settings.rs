//! Suggests command line flags for the rendering settings of a Mitsuba scene.

use super::context::ImportContext;
use super::files::ReadResult;
use super::tree::{MitsubaObject, ObjectClass};
use std::rc::Rc;

/// Integrators of Mitsuba, each with the most similar algorithm of Caustica.
const INTEGRATOR_NAMES: [(&str, &str); 13] = [
    ("path", "path"),
    ("prbvolpath", "path"),
    ("volpath", "path"),
    ("volpath_simple", "path"),
    ("volpathmis", "path"),
    ("prb", "path"),
    ("direct", "path"),
    ("ptracer", "hybrid"),
    ("bdpt", "hybrid"),
    ("photonmapper", "pm"),
    ("ppm", "ppm"),
    ("sppm", "sppm"),
    ("pssmlt", "path"),
];

/// Pixel filters of Mitsuba, each with the most similar filter of `caustica render --filter`.
const FILTER_NAMES: [(&str, &str); 5] =
    [("box", "box"), ("tent", "tent"), ("gaussian", "gaussian"), ("mitchell", "mitchell"), ("catmullrom", "mitchell")];

/// Greatest nesting depth of integrators.
const MAX_INTEGRATOR_DEPTH: u32 = 16;

/// Returns the flags of `caustica render` that correspond to the scene's integrator and pixel
/// filter.
///
/// The text is empty if neither of the two has a corresponding flag.
pub(super) fn suggested_flags(context: &ImportContext<'_>, sensor: Option<&Rc<MitsubaObject>>) -> ReadResult<String> {
    let mut flags = Vec::new();
    let integrators = context.children_of_class(&context.tree.root, ObjectClass::Integrator)?;
    if let Some((_, integrator)) = integrators.first() {
        let inner = innermost_integrator(context, integrator)?;
        if let Some((_, algorithm)) = INTEGRATOR_NAMES.iter().find(|(mitsuba_name, _)| *mitsuba_name == inner.plugin) {
            flags.push(format!("--integrator {algorithm}"));
        }
        // Mitsuba counts the edges of a path, and Caustica its bounces. Direct light has two edges
        // and no bounce. The depth −1 stands for no limit.
        let depth = if inner.plugin == "direct" { Some(2.0) } else { inner.number("max_depth") };
        if let Some(depth) = depth.filter(|depth| *depth >= 2.0) {
            flags.push(format!("--max-bounces {}", depth - 2.0));
        }
    }
    let Some(sensor) = sensor else { return Ok(flags.join(" ")) };
    if let Some(film) = context.named_or_unnamed_child(sensor, ObjectClass::Film, "film")?
        && let Some(filter) = context.named_or_unnamed_child(&film, ObjectClass::Filter, "rfilter")?
    {
        filter.mark_as_read();
        if let Some((_, name)) = FILTER_NAMES.iter().find(|(mitsuba_name, _)| *mitsuba_name == filter.plugin) {
            flags.push(format!("--filter {name}"));
        }
    }
    if let Some(sampler) = context.named_or_unnamed_child(sensor, ObjectClass::Sampler, "sampler")? {
        sampler.mark_as_read();
    }
    Ok(flags.join(" "))
}

/// Returns the innermost integrator that `outer` wraps; `outer` itself if it wraps none.
///
/// Integrators such as `moment` and `aov` wrap another integrator, which may wrap a further one.
/// The values of all of them are marked as read.
fn innermost_integrator(context: &ImportContext<'_>, outer: &Rc<MitsubaObject>) -> ReadResult<Rc<MitsubaObject>> {
    let mut inner = Rc::clone(outer);
    for _ in 0..=MAX_INTEGRATOR_DEPTH {
        inner.mark_as_read();
        match context.children_of_class(&inner, ObjectClass::Integrator)?.into_iter().next() {
            Some((_, nested)) => inner = nested,
            None => return Ok(inner),
        }
    }
    let message = "integrators are nested too deep, or contain themselves";
    Err(outer.place.error(message, "nest them less deep"))
}
