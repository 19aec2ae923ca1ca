//! Typed reading of buffers. An [`Accessor`] has been checked as a whole when it is opened; its
//! elements are then read where they lie, so that the memory in use follows the geometry that is
//! kept and not the numbers that the file claims.

use glam::{DMat4, Vec2, Vec3, Vec4};

use gltf::json::Index;
use gltf::json::accessor::{ComponentType as Component, Type, sparse};
use gltf::json::buffer::View;
use gltf::json::validation::{Checked, USize64};

use super::context::{Context, Outcome, get};

/// An array of elements in a buffer, each within its bounds.
#[derive(Debug)]
pub struct Accessor<'a> {
    /// Elements.
    pub count: usize,
    /// Numbers in each element: 1 to 4, or 16.
    pub lanes: usize,
    component: Component,
    normalized: bool,
    /// `None`: zeros.
    dense: Option<Array<'a>>,
    sparse: Option<(Array<'a>, Component, Array<'a>)>,
}

/// `count` elements of `size` bytes, `stride` bytes apart.
#[derive(Debug)]
struct Array<'a> {
    bytes: &'a [u8],
    stride: usize,
    size: usize,
    count: usize,
}

impl<'a> Array<'a> {
    /// `None` where the array reaches out of `bytes`.
    fn new(bytes: &'a [u8], offset: u64, stride: usize, size: usize, count: usize) -> Option<Self> {
        let bytes = bytes.get(usize::try_from(offset).ok()?..)?;
        let end = match count.checked_sub(1) {
            Some(last) => last.checked_mul(stride)?.checked_add(size)?,
            None => 0,
        };
        (end <= bytes.len()).then_some(Self { bytes, stride, size, count })
    }

    fn element(&self, index: usize) -> &'a [u8] {
        if index >= self.count {
            return &[];
        }
        // In range: `new` has checked the last element's end.
        let start = index * self.stride;
        &self.bytes[start..start + self.size]
    }
}

impl<'a> Accessor<'a> {
    /// Opens an accessor for `user`, as messages call it; its elements must have one of `lanes`
    /// numbers.
    pub fn open(
        context: &Context<'a>,
        index: Index<gltf::json::Accessor>,
        user: &str,
        lanes: &[usize],
    ) -> Outcome<Self> {
        let document = context.document;
        let index = index.value();
        let accessor = get(&document.root.accessors, "accessor", index, user)?;
        let broken = |what: String| format!("{user}: accessor {index} {what}");
        let Checked::Valid(component) = accessor.component_type else {
            return Err(broken("has an unknown component type".to_owned()));
        };
        let component = component.0;
        let found = lanes_of(accessor.type_).filter(|found| lanes.contains(found)).ok_or_else(|| {
            let expected: Vec<_> = lanes.iter().map(|&lanes| shape_of(lanes)).collect();
            broken(format!("is of {}; {} expected", type_name(accessor.type_), expected.join(" or ")))
        })?;
        // Vertices are counted in 32 bits everywhere.
        let count = u32::try_from(accessor.count.0)
            .map_err(|_| broken(format!("has the impossible count {}", accessor.count.0)))?
            as usize;
        let size = component.size() * found;
        let beyond = || broken("reaches beyond the end of its buffer view".to_owned());
        let dense = match accessor.buffer_view {
            None => None,
            Some(view) => {
                let (view, bytes) = document.view(view, user)?;
                let stride = view.byte_stride.map_or(0, |stride| stride.0);
                let stride = if stride == 0 { size } else { stride };
                if stride < size {
                    return Err(broken(format!("has elements of {size} bytes only {stride} bytes apart")));
                }
                let offset = accessor.byte_offset.map_or(0, |offset| offset.0);
                Some(Array::new(bytes, offset, stride, size, count).ok_or_else(beyond)?)
            }
        };
        let sparse = match &accessor.sparse {
            Some(sparse) => Some(open_sparse(context, sparse, size, count, user).map_err(broken)?),
            None => None,
        };
        Ok(Self { count, lanes: found, component, normalized: accessor.normalized, dense, sparse })
    }

    /// The elements are whole numbers that are not normalised: vertex indices or joints.
    pub fn is_integer(&self) -> bool {
        matches!(self.component, Component::U8 | Component::U16 | Component::U32)
    }

    /// The same with integers taken as fractions even where the file forgot to say so: for
    /// attributes that allow nothing else.
    pub fn normalized(mut self) -> Self {
        self.normalized = true;
        self
    }

    fn element(&self, index: usize) -> &'a [u8] {
        if let Some((indices, component, values)) = &self.sparse {
            let (mut low, mut high) = (0, indices.count);
            while low < high {
                let middle = low + (high - low) / 2;
                let at = integer(indices.element(middle), *component, 0) as usize;
                match at.cmp(&index) {
                    std::cmp::Ordering::Equal => return values.element(middle),
                    std::cmp::Ordering::Less => low = middle + 1,
                    std::cmp::Ordering::Greater => high = middle,
                }
            }
        }
        self.dense.as_ref().map_or(&[], |dense| dense.element(index))
    }

    /// One number of element `index`; 0 beyond the end.
    pub fn number(&self, index: usize, lane: usize) -> f32 {
        number(self.element(index), self.component, self.normalized, lane)
    }

    /// One number of element `index` of a [whole-number](Self::is_integer) accessor.
    pub fn integer(&self, index: usize, lane: usize) -> u32 {
        integer(self.element(index), self.component, lane)
    }

    /// Element `index` with two numbers.
    pub fn vec2(&self, index: usize) -> Vec2 {
        Vec2::from_array(self.numbers(index))
    }

    /// Element `index` with three numbers.
    pub fn vec3(&self, index: usize) -> Vec3 {
        Vec3::from_array(self.numbers(index))
    }

    /// Element `index` with four numbers.
    pub fn vec4(&self, index: usize) -> Vec4 {
        Vec4::from_array(self.numbers(index))
    }

    /// Element `index` of an accessor of 4x4 matrices.
    pub fn mat4(&self, index: usize) -> DMat4 {
        DMat4::from_cols_array(&self.numbers(index).map(f64::from))
    }

    fn numbers<const N: usize>(&self, index: usize) -> [f32; N] {
        let element = self.element(index);
        std::array::from_fn(|lane| number(element, self.component, self.normalized, lane))
    }
}

fn open_sparse<'a>(
    context: &Context<'a>,
    sparse: &sparse::Sparse,
    size: usize,
    count: usize,
    user: &str,
) -> Outcome<(Array<'a>, Component, Array<'a>)> {
    let replaced = usize::try_from(sparse.count.0).unwrap_or(usize::MAX);
    if replaced > count {
        return Err(format!("replaces {replaced} of {count} elements"));
    }
    // The crate knows no other types of indices.
    let Checked::Valid(component) = sparse.indices.component_type else {
        return Err("has sparse indices that are not unsigned integers".to_owned());
    };
    let component = component.0;
    let open = |view: Index<View>, offset: USize64, size: usize| {
        let (_, bytes) = context.document.view(view, user)?;
        Array::new(bytes, offset.0, size, size, replaced)
            .ok_or_else(|| "has sparse data that reach beyond the end of their buffer view".to_owned())
    };
    let indices = open(sparse.indices.buffer_view, sparse.indices.byte_offset, component.size())?;
    let values = open(sparse.values.buffer_view, sparse.values.byte_offset, size)?;
    // Checked each time that the accessor is used, which a file can do often.
    context.work(replaced as u64, user)?;
    let mut last = None;
    for i in 0..replaced {
        let index = integer(indices.element(i), component, 0) as usize;
        if index >= count || last.is_some_and(|last| last >= index) {
            return Err("has sparse indices that do not rise within its count".to_owned());
        }
        last = Some(index);
    }
    Ok((indices, component, values))
}

/// `None` for what nothing in a scene is made of: the smaller matrices, whose columns are padded.
fn lanes_of(shape: Checked<Type>) -> Option<usize> {
    match shape {
        Checked::Valid(Type::Mat2 | Type::Mat3) | Checked::Invalid => None,
        Checked::Valid(shape) => Some(shape.multiplicity()),
    }
}

fn type_name(shape: Checked<Type>) -> &'static str {
    match shape {
        Checked::Valid(Type::Scalar) => "type SCALAR",
        Checked::Valid(Type::Vec2) => "type VEC2",
        Checked::Valid(Type::Vec3) => "type VEC3",
        Checked::Valid(Type::Vec4) => "type VEC4",
        Checked::Valid(Type::Mat2) => "type MAT2",
        Checked::Valid(Type::Mat3) => "type MAT3",
        Checked::Valid(Type::Mat4) => "type MAT4",
        Checked::Invalid => "an unknown type",
    }
}

fn shape_of(lanes: usize) -> &'static str {
    match lanes {
        1 => "SCALAR",
        2 => "VEC2",
        3 => "VEC3",
        4 => "VEC4",
        _ => "MAT4",
    }
}

/// The bytes of one number; zeros where the element is too short, which stands for no data.
fn bytes<const N: usize>(element: &[u8], lane: usize) -> [u8; N] {
    let start = lane * N;
    element.get(start..start + N).and_then(|bytes| bytes.try_into().ok()).unwrap_or([0; N])
}

fn integer(element: &[u8], component: Component, lane: usize) -> u32 {
    match component {
        Component::U8 | Component::I8 => u32::from(u8::from_le_bytes(bytes(element, lane))),
        Component::U16 | Component::I16 => u32::from(u16::from_le_bytes(bytes(element, lane))),
        Component::U32 | Component::F32 => u32::from_le_bytes(bytes(element, lane)),
    }
}

fn number(element: &[u8], component: Component, normalized: bool, lane: usize) -> f32 {
    let fraction = |value: f32, greatest: f32| {
        // The most negative integer stands for -1 just as its neighbour does.
        if normalized { (value / greatest).max(-1.0) } else { value }
    };
    match component {
        Component::I8 => fraction(f32::from(i8::from_le_bytes(bytes(element, lane))), 127.0),
        Component::U8 => fraction(f32::from(u8::from_le_bytes(bytes(element, lane))), 255.0),
        Component::I16 => fraction(f32::from(i16::from_le_bytes(bytes(element, lane))), 32767.0),
        Component::U16 => fraction(f32::from(u16::from_le_bytes(bytes(element, lane))), 65535.0),
        Component::U32 => fraction(u32::from_le_bytes(bytes(element, lane)) as f32, u32::MAX as f32),
        Component::F32 => f32::from_le_bytes(bytes(element, lane)),
    }
}
