//! Merging of equal vertices, by a hash table of distinct values.

use super::TriangleMesh;
use ahash::RandomState;
use glam::{DVec2, DVec3};
use hashbrown::HashTable;
use hashbrown::hash_table::Entry;
use std::hash::Hash;

/// List of values with distinct keys. A hash table maps a key to the index of its value.
pub(in crate::format) struct DeduplicatedList<T> {
    hasher: RandomState,
    table: HashTable<u32>,
    list: Vec<T>,
}

impl<T> DeduplicatedList<T> {
    pub fn with_capacity(n: usize) -> Self {
        // Indices depend only on the order of insertion, so any seeds of the hash function work.
        let hasher = RandomState::with_seeds(1, 2, 3, 4);
        Self { hasher, table: HashTable::with_capacity(n), list: Vec::with_capacity(n) }
    }

    /// Returns the index of the listed value that has the same key as `value`.
    ///
    /// If no listed value has this key, appends `value` and returns the index of `value`.
    #[inline]
    pub fn find_or_append<K: Hash + Eq>(&mut self, value: T, key: impl Fn(&T) -> K) -> u32 {
        let Self { hasher, table, list } = self;
        let own = key(&value);
        let equal = |i: &u32| key(&list[*i as usize]) == own;
        match table.entry(hasher.hash_one(&own), equal, |&i| hasher.hash_one(key(&list[i as usize]))) {
            Entry::Occupied(found) => *found.get(),
            Entry::Vacant(place) => {
                let next = list.len() as u32;
                place.insert(next);
                list.push(value);
                next
            }
        }
    }

    /// Returns the values in the order of their indices.
    pub fn into_values(self) -> Vec<T> {
        self.list
    }
}

/// Returns the bit patterns of the three coordinates of `p`.
pub(in crate::format) fn coordinate_bits(p: DVec3) -> [u64; 3] {
    p.to_array().map(f64::to_bits)
}

/// Returns the bit patterns of the coordinates of `p`, so that −0 and 0 give the same bits.
fn position_bits_unsigned_zero(p: DVec3) -> [u64; 3] {
    coordinate_bits(p + DVec3::ZERO)
}

const UNASSIGNED: u32 = u32::MAX;

pub(super) fn merge_equal_vertices(mesh: &mut TriangleMesh) {
    let normals = mesh.normals.as_deref();
    let mut known: Vec<u32> = vec![UNASSIGNED; mesh.positions.len()];
    // New vertices, each with two values: the index of the old vertex, and true if the new vertex
    // has no normal.
    let mut new_vertices: DeduplicatedList<(u32, bool)> = DeduplicatedList::with_capacity(mesh.positions.len());
    let key = |&(v, flat): &(u32, bool)| {
        let normal = normals.filter(|_| !flat).map_or(DVec3::ZERO, |n| n[v as usize]);
        let texcoord = mesh.texcoords.as_ref().map_or(DVec2::ZERO, |t| t[v as usize]);
        (coordinate_bits(mesh.positions[v as usize]), coordinate_bits(normal), texcoord.to_array().map(f64::to_bits))
    };
    for triangle in &mut mesh.triangles {
        let flat = normals.is_some_and(|n| triangle.iter().any(|&v| n[v as usize] == DVec3::ZERO));
        for v in triangle {
            let seen = known[*v as usize];
            if seen != UNASSIGNED && !flat {
                *v = seen;
                continue;
            }
            let number = new_vertices.find_or_append((*v, flat), key);
            if !flat {
                known[*v as usize] = number;
            }
            *v = number;
        }
    }
    let vertices = new_vertices.into_values();
    if let Some(normals) = mesh.normals.take() {
        let normal = |&(v, flat): &(u32, bool)| if flat { DVec3::ZERO } else { normals[v as usize] };
        let normals: Vec<DVec3> = vertices.iter().map(normal).collect();
        mesh.normals = normals.iter().any(|n| *n != DVec3::ZERO).then_some(normals);
    }
    keep_listed_vertices(mesh, vertices.iter().map(|(v, _)| *v));
}

/// Makes vertex i of `mesh` a copy of its old vertex `list[i]`, and drops all other vertices.
///
/// Changes only positions and texture coordinates. The caller must replace normals and triangles.
pub(super) fn keep_listed_vertices(mesh: &mut TriangleMesh, list: impl Iterator<Item = u32> + Clone) {
    mesh.positions = list.clone().map(|v| mesh.positions[v as usize]).collect();
    let texcoord = |texcoords: Vec<DVec2>| list.map(|v| texcoords[v as usize]).collect();
    mesh.texcoords = mesh.texcoords.take().map(texcoord);
}

pub(super) fn distinct_position_indices(mesh: &TriangleMesh) -> (Vec<u32>, usize) {
    let mut distinct = DeduplicatedList::with_capacity(mesh.positions.len());
    let indices =
        mesh.positions.iter().map(|p| distinct.find_or_append(position_bits_unsigned_zero(*p), |key| *key)).collect();
    (indices, distinct.into_values().len())
}

pub(super) fn distinct_position_count(mesh: &TriangleMesh) -> usize {
    let mut distinct = DeduplicatedList::with_capacity(mesh.positions.len());
    mesh.positions.iter().for_each(|p| {
        distinct.find_or_append(coordinate_bits(*p), |key| *key);
    });
    distinct.into_values().len()
}
