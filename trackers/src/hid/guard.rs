//! Makes a report descriptor safe to parse: [`hidparser`] trusts what it is given. Counts are multiplied
//! without a check, every field holds a copy of all collections around it (each of which holds a copy of
//! those around it, so that memory doubles with each level), and Pop restores nothing.

use super::descriptor::DescriptorError;

/// `HID_MAX_DESCRIPTOR_SIZE` of the Linux kernel.
pub const MAX_BYTES: usize = 4096;
/// Levels of collections. Trackers use three or four.
const MAX_DEPTH: u32 = 8;
/// Pushed states; what exists uses one.
const MAX_PUSHED: usize = 8;
/// Bits of all reports together: eight reports of `HID_MAX_BUFFER_SIZE`, 16 KiB, of the Linux kernel.
const MAX_BITS: u64 = 8 * 16384 * 8;
/// Records of 48 bytes, the size of a collection, that the parser would make: more allows larger
/// descriptors and more memory (13 MB as it is). Microsoft's two descriptors cost 659 and 779.
const MAX_RECORDS: u64 = 1 << 18;
/// A field without its collections and usages, in such records.
const FIELD_RECORDS: u64 = 4;

const MAIN: u8 = 0;
const GLOBAL: u8 = 1;
const LOCAL: u8 = 2;
const LONG_ITEM: u8 = 0xfe;

/// A descriptor that can be parsed.
#[derive(Debug, Default)]
pub struct Guarded {
    /// Its bytes: no Push and Pop, no long items, constant fields with usages marked as variables.
    pub bytes: Vec<u8>,
    /// All physical minima and maxima in it, which the parser keeps but does not tell.
    pub physical: Vec<i32>,
}

/// Global items by tag: usage page, logical, physical, unit, size, id, count.
type Globals<'a> = [Option<&'a [u8]>; 10];
const USAGE_PAGE: usize = 0;
const PHYSICAL: std::ops::RangeInclusive<usize> = 3..=4;
const REPORT_SIZE: usize = 7;
const REPORT_ID: usize = 8;
const REPORT_COUNT: usize = 9;

#[derive(Default)]
struct Walk<'a> {
    out: Guarded,
    globals: Globals<'a>,
    pushed: Vec<Globals<'a>>,
    depth: u32,
    locals: u64,
    usages: u64,
    bits: u64,
    records: u64,
}

/// Checks a descriptor against the limits and rewrites it.
///
/// # Errors
/// What is wrong, and at which byte.
pub fn guard(descriptor: &[u8]) -> Result<Guarded, DescriptorError> {
    if descriptor.len() > MAX_BYTES {
        return Err(DescriptorError::at(MAX_BYTES, format!("is longer than {MAX_BYTES} bytes")));
    }
    let mut walk = Walk::default();
    let mut at = 0;
    while let Some(&head) = descriptor.get(at) {
        let broken = || DescriptorError::at(at, "ends within an item");
        let (start, length) = if head == LONG_ITEM {
            (at + 3, usize::from(*descriptor.get(at + 1).ok_or_else(broken)?))
        } else {
            (at + 1, [0, 1, 2, 4][usize::from(head & 3)])
        };
        let data = descriptor.get(start..start + length).ok_or_else(broken)?;
        if head != LONG_ITEM {
            walk.item(head, data).map_err(|what| DescriptorError::at(at, what))?;
        }
        at = start + length;
    }
    if walk.depth > 0 {
        return Err(DescriptorError::at(at, format!("leaves {} collections open", walk.depth)));
    }
    Ok(walk.out)
}

fn unsigned(data: Option<&[u8]>) -> u64 {
    data.unwrap_or_default().iter().rev().fold(0, |value, byte| value << 8 | u64::from(*byte))
}

fn signed(data: &[u8]) -> i32 {
    let unused = 32 - 8 * data.len() as u32;
    // At most 4 bytes, so the cast loses nothing; no bytes are 0.
    ((unsigned(Some(data)) as u32).checked_shl(unused).unwrap_or(0) as i32).checked_shr(unused).unwrap_or(0)
}

impl<'a> Walk<'a> {
    fn item(&mut self, head: u8, data: &'a [u8]) -> Result<(), String> {
        let tag = head >> 4;
        match head >> 2 & 3 {
            MAIN => self.main(head, tag, data)?,
            GLOBAL => self.global(usize::from(tag), data)?,
            LOCAL => {
                self.locals += 1;
                self.usages += u64::from(tag <= 2);
                self.emit(head, data);
            }
            // Reserved for later versions of the standard; the Linux kernel passes over them too.
            _ => {}
        }
        if self.bits > MAX_BITS {
            return Err(format!("makes the reports longer than {MAX_BITS} bits"));
        }
        if self.records > MAX_RECORDS {
            return Err("has too many fields, or fields nested too deeply".to_owned());
        }
        Ok(())
    }

    fn emit(&mut self, head: u8, data: &[u8]) {
        self.out.bytes.push(head);
        self.out.bytes.extend_from_slice(data);
    }

    fn main(&mut self, head: u8, tag: u8, data: &[u8]) -> Result<(), String> {
        match tag {
            0x8 | 0x9 | 0xb => self.field(head, data),
            0xa => {
                self.depth += 1;
                if self.depth > MAX_DEPTH {
                    return Err(format!("nests collections deeper than {MAX_DEPTH}"));
                }
                self.records += 1 << self.depth;
                self.emit(head, data);
            }
            0xc => {
                self.depth = self.depth.checked_sub(1).ok_or("ends a collection that none began")?;
                self.emit(head, data);
            }
            tag => return Err(format!("is a main item of the unknown tag {tag}")),
        }
        self.locals = 0;
        self.usages = 0;
        Ok(())
    }

    fn field(&mut self, head: u8, data: &[u8]) {
        const CONSTANT: u8 = 1;
        const VARIABLE: u8 = 2;
        let (count, size) = (unsigned(self.globals[REPORT_COUNT]), unsigned(self.globals[REPORT_SIZE]));
        // Both are below 2^32 and `bits` is at most MAX_BITS after each item, so nothing overflows.
        self.bits += count * size.max(1);
        let fields = if self.usages > 0 { count } else { 1 };
        self.records += (fields + 1).saturating_mul(FIELD_RECORDS + (1 << self.depth) + self.locals);
        match data.split_first() {
            // Without this the parser would not tell which value belongs to which usage.
            Some((flags, rest)) if flags & CONSTANT != 0 && self.usages > 0 => {
                self.out.bytes.extend([head, flags | VARIABLE]);
                self.out.bytes.extend_from_slice(rest);
            }
            _ => self.emit(head, data),
        }
    }

    fn global(&mut self, tag: usize, data: &'a [u8]) -> Result<(), String> {
        match tag {
            0xa if self.pushed.len() >= MAX_PUSHED => {
                return Err(format!("pushes more than {MAX_PUSHED} states"));
            }
            0xa => self.pushed.push(self.globals),
            0xb => {
                let before = self.pushed.pop().ok_or("pops a state that none pushed")?;
                return self.restore(before);
            }
            _ => {
                let data = match data {
                    // The parser takes no page in four bytes.
                    [page @ .., 0, 0] if tag == USAGE_PAGE && page.len() == 2 => page,
                    _ => data,
                };
                let slot = self.globals.get_mut(tag).ok_or("is a global item of an unknown tag")?;
                *slot = Some(data);
                if PHYSICAL.contains(&tag) {
                    self.out.physical.push(signed(data));
                }
                if tag == REPORT_ID && !(1..=255).contains(&unsigned(Some(data))) {
                    return Err("gives a report id outside 1..255".to_owned());
                }
                self.emit(global_head(tag, data.len()), data);
            }
        }
        Ok(())
    }

    /// Says again what held before a Push.
    fn restore(&mut self, before: Globals<'a>) -> Result<(), String> {
        for (tag, (then, now)) in before.into_iter().zip(self.globals).enumerate() {
            if then == now {
                continue;
            }
            if tag == REPORT_ID && then.is_none() {
                return Err("goes back from reports with an id to those without".to_owned());
            }
            let data = then.unwrap_or(&[0]);
            self.emit(global_head(tag, data.len()), data);
        }
        self.globals = before;
        Ok(())
    }
}

/// The first byte of a global item with so many bytes of data.
fn global_head(tag: usize, length: usize) -> u8 {
    // Tags end at 9, and data has 0, 1, 2 or 4 bytes.
    (tag as u8) << 4 | GLOBAL << 2 | if length == 4 { 3 } else { length as u8 }
}
