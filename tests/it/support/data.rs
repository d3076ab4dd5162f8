//! Checks that `tests/data` is intact.

use super::project_path;
use std::collections::BTreeSet;
use std::fs;

/// Returns the SHA-256 digest of `bytes` in hexadecimal (FIPS 180-4).
fn sha256(bytes: &[u8]) -> String {
    // The constants of SHA-256 are the first 32 bits of the fractional parts of cube and square
    // roots of the first primes.
    let primes: Vec<u32> = (2..).filter(|n| (2..*n).all(|d| n % d != 0)).take(64).collect();
    let fraction = |prime: u32, root: u32| {
        // `x` is the largest number with x^root <= prime * 2^(32 root), found bit by bit. Its low
        // 32 bits are the fractional part.
        let power = |x: u128| (1..root).try_fold(x, |product, _| product.checked_mul(x));
        let limit = u128::from(prime) << (32 * root);
        let x = (0..36).rev().fold(0u128, |x, bit| {
            let next = x | 1 << bit;
            if power(next).is_some_and(|p| p <= limit) { next } else { x }
        });
        x as u32
    };
    let constants: Vec<u32> = primes.iter().map(|p| fraction(*p, 3)).collect();
    let mut state: Vec<u32> = primes[..8].iter().map(|p| fraction(*p, 2)).collect();
    let mut message = bytes.to_vec();
    message.push(0x80);
    message.resize(message.len().next_multiple_of(64), 0);
    if message.len() - bytes.len() < 9 {
        message.resize(message.len() + 64, 0);
    }
    let end = message.len();
    message[end - 8..].copy_from_slice(&(bytes.len() as u64 * 8).to_be_bytes());
    for block in message.chunks_exact(64) {
        let mut w: Vec<u32> = block.as_chunks().0.iter().map(|word| u32::from_be_bytes(*word)).collect();
        for i in 16..64 {
            let (a, b) = (w[i - 15], w[i - 2]);
            let s0 = a.rotate_right(7) ^ a.rotate_right(18) ^ (a >> 3);
            let s1 = b.rotate_right(17) ^ b.rotate_right(19) ^ (b >> 10);
            w.push(w[i - 16].wrapping_add(s0).wrapping_add(w[i - 7]).wrapping_add(s1));
        }
        let mut v = state.clone();
        for i in 0..64 {
            let s1 = v[4].rotate_right(6) ^ v[4].rotate_right(11) ^ v[4].rotate_right(25);
            let choice = (v[4] & v[5]) ^ (!v[4] & v[6]);
            let t1 = v[7].wrapping_add(s1).wrapping_add(choice).wrapping_add(constants[i]).wrapping_add(w[i]);
            let s0 = v[0].rotate_right(2) ^ v[0].rotate_right(13) ^ v[0].rotate_right(22);
            let majority = (v[0] & v[1]) ^ (v[0] & v[2]) ^ (v[1] & v[2]);
            v.rotate_right(1);
            v[4] = v[4].wrapping_add(t1);
            v[0] = t1.wrapping_add(s0).wrapping_add(majority);
        }
        state.iter_mut().zip(v).for_each(|(s, v)| *s = s.wrapping_add(v));
    }
    state.iter().map(|word| format!("{word:08x}")).collect()
}

#[test]
fn sha256_matches_its_standard() {
    assert_eq!(sha256(b"abc"), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
    let two_blocks = b"abcdbcdecdefdefgefghfghighijhijkijkljklmklmnlmnomnopnopq";
    assert_eq!(sha256(two_blocks), "248d6a61d20638b8e5c026930c3e6039a33ce45964ff2167f6ecedd419db06c1");
}

#[test]
fn reference_data_matches_its_checksums() {
    let folder = project_path("tests/data");
    let list = fs::read_to_string(folder.join("SHA256SUMS")).unwrap();
    let mut listed = BTreeSet::new();
    for line in list.lines() {
        let (digest, name) = line.split_once("  ").unwrap();
        assert_eq!(sha256(&fs::read(folder.join(name)).unwrap()), digest, "tests/data/{name} is damaged");
        listed.insert(name.to_owned());
    }
    let names = fs::read_dir(&folder).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap());
    let present: BTreeSet<String> = names.filter(|name| name.ends_with(".exr")).collect();
    assert_eq!(listed, present, "SHA256SUMS lists every image");
}
