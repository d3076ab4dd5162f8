//! Suggests known words for unknown words of a scene text.

/// Greatest length of an unknown word for which a similar word is suggested \[characters].
const MAX_WORD_LENGTH: usize = 40;

/// Keywords of other renderers and file formats, in lower case, each with the keyword of the scene
/// language that means the same.
const SYNONYMS: [(&str, &str); 46] = [
    ("albedo", "reflectance"),
    ("ambientlight", "EnvironmentLight"),
    ("arealight", "RectangleLight"),
    ("base_color", "reflectance"),
    ("basecolor", "reflectance"),
    ("camera", "PerspectiveCamera"),
    ("color", "reflectance"),
    ("colour", "reflectance"),
    ("diffuse", "diffuseColor"),
    ("diffuse", "reflectance"),
    ("distantlight", "DirectionalLight"),
    ("domelight", "EnvironmentLight"),
    ("envmap", "EnvironmentLight"),
    ("eta", "indexOfRefraction"),
    ("eye", "center"),
    ("filename", "file"),
    ("fov", "angle"),
    ("fovy", "angle"),
    ("from", "center"),
    ("glass", "Dielectric"),
    ("hdri", "EnvironmentLight"),
    ("index", "indexOfRefraction"),
    ("infinitelight", "EnvironmentLight"),
    ("ior", "indexOfRefraction"),
    ("lambert", "Diffuse"),
    ("lambertian", "Diffuse"),
    ("matte", "Diffuse"),
    ("mesh", "TriangleMesh"),
    ("metal", "Conductor"),
    ("objmesh", "TriangleMesh"),
    ("origin", "center"),
    ("panoramacamera", "EnvironmentCamera"),
    ("pinholecamera", "PerspectiveCamera"),
    ("plymesh", "TriangleMesh"),
    ("position", "center"),
    ("quad", "Rectangle"),
    ("quadlight", "RectangleLight"),
    ("skylight", "EnvironmentLight"),
    ("specular", "Mirror"),
    ("specular", "specularColor"),
    ("sunlight", "DirectionalLight"),
    ("sun", "DirectionalLight"),
    ("target", "lookAt"),
    ("thindielectric", "Thin"),
    ("to", "lookAt"),
    ("trianglemesh", "TriangleMesh"),
];

/// Returns the keyword in `allowed` that means the same as `word` does in other renderers; `None`
/// if no keyword does.
pub(in crate::format) fn keyword_synonym(word: &str, allowed: &[&str]) -> Option<&'static str> {
    let word = word.to_ascii_lowercase();
    SYNONYMS.iter().find(|(other, own)| *other == word && allowed.contains(own)).map(|(_, own)| *own)
}

/// Returns the candidate with the smallest edit distance to `word`, regardless of case.
///
/// The distance may be at most a third of the length of `word` or of the candidate, whichever is
/// longer. Returns `None` if no candidate is that near, or if `word` has more than
/// [`MAX_WORD_LENGTH`] letters. Candidates with more letters are skipped.
pub(in crate::format) fn nearest_word<'c>(word: &str, candidates: impl Iterator<Item = &'c str>) -> Option<&'c str> {
    let word: Vec<char> = word.chars().take(MAX_WORD_LENGTH + 1).flat_map(char::to_lowercase).collect();
    if word.len() > MAX_WORD_LENGTH {
        return None;
    }
    candidates
        .filter(|candidate| candidate.chars().nth(MAX_WORD_LENGTH).is_none())
        .map(|candidate| {
            let letters: Vec<char> = candidate.chars().flat_map(char::to_lowercase).collect();
            (edit_distance(&word, &letters), letters.len(), candidate)
        })
        .filter(|&(distance, length, _)| distance <= length.max(word.len()) / 3)
        .min_by_key(|&(distance, ..)| distance)
        .map(|(.., candidate)| candidate)
}

/// Returns the edit distance (optimal string alignment) of two words.
///
/// An edit inserts, deletes or replaces a letter, or swaps two neighbors.
fn edit_distance(a: &[char], b: &[char]) -> usize {
    let mut before = vec![0; b.len() + 1];
    let mut last: Vec<usize> = (0..=b.len()).collect();
    for i in 1..=a.len() {
        let mut row = vec![i; b.len() + 1];
        for j in 1..=b.len() {
            let change = usize::from(a[i - 1] != b[j - 1]);
            row[j] = (last[j] + 1).min(row[j - 1] + 1).min(last[j - 1] + change);
            if i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1] {
                row[j] = row[j].min(before[j - 2] + 1);
            }
        }
        before = std::mem::replace(&mut last, row);
    }
    last[b.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn misspelt_keywords_are_recognised() {
        let words = || ["Sphere", "Plane", "radius", "lookAt", "color"].into_iter();
        for (word, keyword) in
            [("Spere", "Sphere"), ("Shpere", "Sphere"), ("RADIUS", "radius"), ("colour", "color"), ("lookat", "lookAt")]
        {
            assert_eq!(nearest_word(word, words()), Some(keyword));
        }
        assert_eq!(nearest_word("Torus", words()), None);
        assert_eq!(nearest_word("", words()), None);
        assert_eq!(nearest_word(&"Sphere".repeat(1000), words()), None);
        let longest = "ü".repeat(MAX_WORD_LENGTH);
        assert_eq!(nearest_word(&longest, [&*longest].into_iter()), Some(&*longest));
    }

    #[test]
    fn synonyms_are_translated_where_allowed() {
        assert_eq!(keyword_synonym("SunLight", &["PointLight", "DirectionalLight"]), Some("DirectionalLight"));
        assert_eq!(keyword_synonym("ior", &["indexOfRefraction"]), Some("indexOfRefraction"));
        assert_eq!(keyword_synonym("Glass", &["Mirror", "Dielectric"]), Some("Dielectric"));
        assert_eq!(keyword_synonym("Glass", &["Sphere"]), None);
    }
}
