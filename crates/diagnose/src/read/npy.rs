//! Files of one array of numbers, as `numpy.save` writes them: NumPy Enhancement Proposal 1, versions 1 to 3.

/// The numbers of an array file, in their order in the file, or what is wrong with it.
pub(super) fn numbers(bytes: &[u8]) -> Result<Vec<f64>, String> {
    let (header, data) = parts(bytes)?;
    let shape = shape(header)?;
    if shape.iter().filter(|n| **n != 1).count() > 1 || shape.is_empty() {
        return Err(format!("has the shape {shape:?}"));
    }
    let count: usize = shape.iter().product();
    let (big, code) = match entry(header, "descr")?.strip_prefix(['\'', '"']).map(|d| d.split_at_checked(1)) {
        Some(Some(("<" | "|" | "=", code))) => (false, code),
        Some(Some((">", code))) => (true, code),
        _ => return Err("is a table of several types".into()),
    };
    let code = code.split(['\'', '"']).next().unwrap_or_default();
    match code {
        "f8" => read(data, count, big, f64::from_le_bytes),
        "f4" => read(data, count, big, |b| f32::from_le_bytes(b).into()),
        "i8" => read(data, count, big, |b| i64::from_le_bytes(b) as f64),
        "i4" => read(data, count, big, |b| i32::from_le_bytes(b).into()),
        "i2" => read(data, count, big, |b| i16::from_le_bytes(b).into()),
        "i1" => read(data, count, big, |b| i8::from_le_bytes(b).into()),
        "u8" => read(data, count, big, |b| u64::from_le_bytes(b) as f64),
        "u4" => read(data, count, big, |b| u32::from_le_bytes(b).into()),
        "u2" => read(data, count, big, |b| u16::from_le_bytes(b).into()),
        "u1" => read(data, count, big, |b| u8::from_le_bytes(b).into()),
        _ => Err(format!("has the type {code}")),
    }
}

/// Header and data.
fn parts(bytes: &[u8]) -> Result<(&str, &[u8]), String> {
    const MAGIC: &[u8] = b"\x93NUMPY";
    const CUT: &str = "is truncated";
    let rest = bytes.strip_prefix(MAGIC).ok_or("is not a NumPy array")?;
    let (version, rest) = rest.split_at_checked(2).ok_or(CUT)?;
    let (length, rest) = if version[0] == 1 {
        let (length, rest) = rest.split_first_chunk().ok_or(CUT)?;
        (usize::from(u16::from_le_bytes(*length)), rest)
    } else {
        let (length, rest) = rest.split_first_chunk().ok_or(CUT)?;
        (u32::from_le_bytes(*length) as usize, rest)
    };
    let (header, data) = rest.split_at_checked(length).ok_or(CUT)?;
    Ok((std::str::from_utf8(header).map_err(|e| e.to_string())?, data))
}

/// What follows a key of the header.
fn entry<'a>(header: &'a str, key: &str) -> Result<&'a str, String> {
    let quoted = ['\'', '"'].into_iter().find_map(|q| header.split_once(&format!("{q}{key}{q}")));
    let value = quoted.and_then(|(_, rest)| rest.trim_start().strip_prefix(':'));
    value.map(str::trim_start).ok_or_else(|| format!("has a header without `{key}`"))
}

/// The sizes of the array.
fn shape(header: &str) -> Result<Vec<usize>, String> {
    let inside = entry(header, "shape")?.strip_prefix('(').and_then(|s| s.split_once(')'));
    let (inside, _) = inside.ok_or("has a header that does not describe an array of numbers")?;
    let sizes = inside.split(',').map(str::trim).filter(|size| !size.is_empty());
    sizes.map(|size| size.parse().map_err(|_| format!("has {size} entries"))).collect()
}

/// So many numbers of `N` bytes each.
fn read<const N: usize>(
    data: &[u8],
    count: usize,
    big: bool,
    number: impl Fn([u8; N]) -> f64,
) -> Result<Vec<f64>, String> {
    let (all, _) = data.as_chunks::<N>();
    let all = all.get(..count).ok_or_else(|| format!("is truncated: {} of {count} entries", all.len()))?;
    let in_order = |mut bytes: [u8; N]| {
        if big {
            bytes.reverse();
        }
        number(bytes)
    };
    Ok(all.iter().map(|bytes| in_order(*bytes)).collect())
}
