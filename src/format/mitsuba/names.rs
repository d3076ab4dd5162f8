//! Spelling of names in Mitsuba files: `toWorld` in old files, and `to_world` in later ones.

/// Returns a name in snake case: `toWorld` becomes `to_world`, and `intIOR` becomes `int_ior`.
pub(super) fn snake_case(name: &str) -> String {
    let mut snake = String::with_capacity(name.len() + 4);
    let mut follows_lowercase = false;
    for c in name.chars() {
        if c.is_ascii_uppercase() && follows_lowercase {
            snake.push('_');
        }
        follows_lowercase = c.is_ascii_lowercase() || c.is_ascii_digit();
        snake.push(c.to_ascii_lowercase());
    }
    snake
}

#[cfg(test)]
mod tests {
    use super::snake_case;

    #[test]
    fn both_spellings_become_snake_case() {
        let names = ["toWorld", "to_world", "intIOR", "sigmaT", "fovAxis", "maxDepth", "alpha", "color0"];
        let expected = ["to_world", "to_world", "int_ior", "sigma_t", "fov_axis", "max_depth", "alpha", "color0"];
        assert_eq!(names.map(snake_case), expected);
    }
}
