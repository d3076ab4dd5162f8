//! One vertex for all that agree.

use super::TriangleMesh;
use ahash::RandomState;
use glam::{DVec2, DVec3};
use hashbrown::HashTable;

/// Finds equal keys among those that came before, by their number.
pub(in crate::format) struct Numbers<K> {
    hasher: RandomState,
    table: HashTable<u32>,
    keys: Vec<K>,
}

impl<K: std::hash::Hash + Eq> Numbers<K> {
    pub fn with_capacity(n: usize) -> Self {
        // Numbers depend on the order of keys alone, so any seed does.
        let hasher = RandomState::with_seeds(1, 2, 3, 4);
        Self { hasher, table: HashTable::with_capacity(n), keys: Vec::with_capacity(n) }
    }

    /// The number of `key`, which is the next one where it is new.
    pub fn number(&mut self, key: K) -> u32 {
        let Self { hasher, table, keys } = self;
        let hash = hasher.hash_one(&key);
        let entry = table.entry(hash, |&i| keys[i as usize] == key, |&i| hasher.hash_one(&keys[i as usize]));
        match entry {
            hashbrown::hash_table::Entry::Occupied(found) => *found.get(),
            hashbrown::hash_table::Entry::Vacant(place) => {
                let next = keys.len() as u32;
                place.insert(next);
                keys.push(key);
                next
            }
        }
    }

    pub fn into_keys(self) -> Vec<K> {
        self.keys
    }
}

/// The bits of a point.
pub(in crate::format) fn bits(p: DVec3) -> [u64; 3] {
    p.to_array().map(f64::to_bits)
}

/// The bits of a place: its two zeros are one.
fn place(p: DVec3) -> [u64; 3] {
    bits(p + DVec3::ZERO)
}

type Vertex = ([u64; 3], [u64; 3], [u64; 2]);

const UNKNOWN: u32 = u32::MAX;

impl TriangleMesh {
    /// Makes vertices one that agree in every bit, drops those that no triangle uses, and numbers the others by first use.
    /// Where one corner of a triangle has no normal, none keeps its own.
    pub fn share(&mut self) {
        let mut known: Vec<u32> = vec![UNKNOWN; self.positions.len()];
        let mut numbers: Numbers<Vertex> = Numbers::with_capacity(self.positions.len());
        let normal = |v: u32| self.normals.as_ref().map_or(DVec3::ZERO, |n| n[v as usize]);
        let texcoord = |v: u32| self.texcoords.as_ref().map_or(DVec2::ZERO, |t| t[v as usize]);
        let has_normals = self.normals.is_some();
        for triangle in &mut self.triangles {
            let flat = has_normals && triangle.iter().any(|&v| normal(v) == DVec3::ZERO);
            for v in triangle {
                let seen = known[*v as usize];
                if seen != UNKNOWN && !flat {
                    *v = seen;
                    continue;
                }
                let n = if flat { DVec3::ZERO } else { normal(*v) };
                let key = (bits(self.positions[*v as usize]), bits(n), texcoord(*v).to_array().map(f64::to_bits));
                let number = numbers.number(key);
                if !flat {
                    known[*v as usize] = number;
                }
                *v = number;
            }
        }
        let vertices = numbers.into_keys();
        let point = |b: [u64; 3]| DVec3::from_array(b.map(f64::from_bits));
        self.positions = vertices.iter().map(|v| point(v.0)).collect();
        if has_normals {
            let some = vertices.iter().any(|v| point(v.1) != DVec3::ZERO);
            self.normals = some.then(|| vertices.iter().map(|v| point(v.1)).collect());
        }
        if self.texcoords.is_some() {
            self.texcoords = Some(vertices.iter().map(|v| DVec2::from_array(v.2.map(f64::from_bits))).collect());
        }
    }

    /// Makes the vertices copies of those listed, but for their normals, which have been made already.
    pub(super) fn take(&mut self, list: impl Iterator<Item = u32> + Clone) {
        self.positions = list.clone().map(|v| self.positions[v as usize]).collect();
        let texcoord = |texcoords: Vec<DVec2>| list.map(|v| texcoords[v as usize]).collect();
        self.texcoords = self.texcoords.take().map(texcoord);
    }

    /// The number of each vertex's place: vertices at the same place have the same number. And how many places there are.
    #[must_use]
    pub fn places(&self) -> (Vec<u32>, usize) {
        let mut numbers = Numbers::with_capacity(self.positions.len());
        let places = self.positions.iter().map(|p| numbers.number(place(*p))).collect();
        (places, numbers.into_keys().len())
    }

    pub(super) fn distinct_positions(&self) -> usize {
        let mut numbers = Numbers::with_capacity(self.positions.len());
        self.positions.iter().for_each(|p| {
            numbers.number(bits(*p));
        });
        numbers.into_keys().len()
    }
}
