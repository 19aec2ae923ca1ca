//! The meanings that usage page 0x12 (Eye and Head Trackers, HID Usage Tables 1.2 and later) gives to a
//! field. A position means nothing by itself: the collection around it says whose it is.

/// The usage page of eye and head trackers.
pub const USAGE_PAGE: u16 = 0x12;

/// What a value is measured in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    /// s
    Time,
    /// m
    Length,
    /// rad
    Angle,
    /// Hz
    Frequency,
    /// A number, a code or a set of bits.
    Plain,
}

macro_rules! roles {
    ($($(#[$doc:meta])* $name:ident = $kind:ident, $collection:pat, $usage:literal;)*) => {
        /// What a field of a report means. Values come in SI units: m, s, rad, Hz.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        pub enum Role {
            $($(#[$doc])* $name,)*
        }

        impl Role {
            /// All of them.
            pub const ALL: &[Self] = &[$(Self::$name),*];

            /// By the usage of the nearest collection of the page, and the field's own.
            pub(super) fn of(collection: u16, usage: u16) -> Option<Self> {
                match (collection, usage) {
                    $(($collection, $usage) => Some(Self::$name),)*
                    _ => None,
                }
            }

            pub(super) fn kind(self) -> Kind {
                match self {
                    $(Self::$name => Kind::$kind,)*
                }
            }
        }
    };
}

roles! {
    /// When the sample was taken, on the tracker's clock.
    Timestamp = Time, _, 0x20;
    /// Gaze on the display, from its left edge.
    GazeX = Length, 0x24, 0x21;
    /// Gaze on the display, from its top edge.
    GazeY = Length, 0x24, 0x22;
    /// The left eye, to the right.
    LeftX = Length, 0x25, 0x21;
    /// The left eye, down.
    LeftY = Length, 0x25, 0x22;
    /// The left eye, out of the display.
    LeftZ = Length, 0x25, 0x23;
    /// The right eye, to the right.
    RightX = Length, 0x26, 0x21;
    /// The right eye, down.
    RightY = Length, 0x26, 0x22;
    /// The right eye, out of the display.
    RightZ = Length, 0x26, 0x23;
    /// The head, to the right.
    HeadX = Length, 0x27, 0x21;
    /// The head, down.
    HeadY = Length, 0x27, 0x22;
    /// The head, out of the display.
    HeadZ = Length, 0x27, 0x23;
    /// Where the head points, from the display's left edge.
    HeadPointX = Length, 0x28, 0x21;
    /// Where the head points, from the display's top edge.
    HeadPointY = Length, 0x28, 0x22;
    /// Where the head points, out of the display.
    HeadPointZ = Length, 0x28, 0x23;
    /// The head's rotation about X.
    HeadRotationX = Angle, _, 0x29;
    /// The head's rotation about Y.
    HeadRotationY = Angle, _, 0x2a;
    /// The head's rotation about Z.
    HeadRotationZ = Angle, _, 0x2b;
    /// 0: a head tracker only, 1: fine gaze.
    TrackerQuality = Plain, _, 0x100;
    /// Nearest distance at which it tracks.
    MinimumDistance = Length, _, 0x101;
    /// Best distance.
    OptimumDistance = Length, _, 0x102;
    /// Farthest distance at which it tracks.
    MaximumDistance = Length, _, 0x103;
    /// Widest display that it covers.
    MaximumScreenWidth = Length, _, 0x104;
    /// Highest display that it covers.
    MaximumScreenHeight = Length, _, 0x105;
    /// The display's manufacturer, as in its EDID.
    DisplayManufacturer = Plain, _, 0x200;
    /// The display's product id, as in its EDID.
    DisplayProduct = Plain, _, 0x201;
    /// The display's serial number, as in its EDID.
    DisplaySerial = Plain, _, 0x202;
    /// The display's date of manufacture, as in its EDID.
    DisplayDate = Plain, _, 0x203;
    /// Width of the display that it is calibrated to.
    ScreenWidth = Length, _, 0x204;
    /// Height of the display that it is calibrated to.
    ScreenHeight = Length, _, 0x205;
    /// Samples per second.
    SamplingFrequency = Frequency, _, 0x300;
    /// See [`super::ConfigurationStatus`].
    ConfigurationStatus = Plain, _, 0x301;
    /// See [`super::ModeRequest`].
    ModeRequest = Plain, _, 0x400;
}

/// How many roles there are.
pub(super) const COUNT: usize = Role::ALL.len();

impl Role {
    pub(super) fn index(self) -> usize {
        self as usize
    }

    /// Whether it tells of the eyes or the head.
    pub(super) fn is_tracking(self) -> bool {
        (Self::GazeX as usize..=Self::HeadRotationZ as usize).contains(&(self as usize))
    }
}
