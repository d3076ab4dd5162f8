//! Transforms that mirror, shear, squeeze and nest: distances and normals stay right, singular ones are refused.
