//! The shapes of a scene. Copies of the scene for all shutter times share the shapes at rest, but
//! not the moving shapes.

use crate::shape::Shape;
use std::ops::Index;
use std::sync::Arc;

/// Shapes by index: shapes at rest, then moving shapes.
///
/// Clones share the shapes at rest.
#[derive(Clone)]
pub(super) struct ShapeList {
    resting: Arc<[Shape]>,
    moving: Vec<Shape>,
}

impl ShapeList {
    /// Makes a list of `shapes`. Shapes from index `first_moving` on move.
    pub fn new(mut shapes: Vec<Shape>, first_moving: u32) -> Self {
        let moving = shapes.split_off(first_moving as usize);
        Self { resting: shapes.into(), moving }
    }

    /// All shapes at rest, by index.
    #[inline]
    pub fn resting(&self) -> &[Shape] {
        &self.resting
    }

    /// All moving shapes, in the order of their indices.
    #[inline]
    pub fn moving(&self) -> &[Shape] {
        &self.moving
    }

    /// Index of the first moving shape in the list of all shapes.
    #[inline]
    pub fn first_moving_index(&self) -> u32 {
        self.resting.len() as u32
    }

    pub fn len(&self) -> usize {
        self.resting.len() + self.moving.len()
    }

    pub fn iter(&self) -> impl Iterator<Item = &Shape> {
        self.resting.iter().chain(&self.moving)
    }

    /// Replaces moving shape `i`, counted from the first moving shape.
    pub fn replace_moving(&mut self, i: usize, shape: Shape) {
        self.moving[i] = shape;
    }
}

impl Index<u32> for ShapeList {
    type Output = Shape;

    #[inline]
    fn index(&self, i: u32) -> &Shape {
        let i = i as usize;
        self.resting.get(i).unwrap_or_else(|| &self.moving[i - self.resting.len()])
    }
}
