/// Why no picture came out, and what to do about it.
#[derive(Debug, thiserror::Error)]
pub enum RenderError {
    /// No adapter fits the request.
    #[error(
        "no graphics adapter {wanted}; found: {found}. Install a Vulkan driver (Debian: mesa-vulkan-drivers) or choose another with --adapter"
    )]
    NoAdapter {
        /// What was asked for.
        wanted: String,
        /// Names of what is there.
        found: String,
    },
    /// The adapter refused a device.
    #[error("adapter {adapter} gives no device: {reason}")]
    NoDevice {
        /// Adapter name.
        adapter: String,
        /// The driver's words.
        reason: String,
    },
    /// The adapter lacks something that every frame needs.
    #[error("adapter {adapter} lacks {feature}; choose another with --adapter")]
    MissingFeature {
        /// Adapter name.
        adapter: String,
        /// What is missing.
        feature: String,
    },
    /// The adapter lacks something that a shadow technique needs.
    #[error(
        "shadow technique `{technique}` needs {features}, which adapter {adapter} lacks; choose another technique or adapter"
    )]
    NeedsFeature {
        /// Name of the technique.
        technique: &'static str,
        /// What is missing, by WebGPU's names.
        features: String,
        /// Adapter name.
        adapter: String,
    },
    /// A setting names nothing that exists.
    #[error("unknown {what} `{name}`; choose one of: {choices}")]
    UnknownName {
        /// Kind of thing.
        what: &'static str,
        /// The name given.
        name: String,
        /// All names.
        choices: String,
    },
    /// A setting is out of range.
    #[error("{what} must be {range}, not {value}")]
    OutOfRange {
        /// The setting.
        what: &'static str,
        /// The range, in words.
        range: String,
        /// The value given.
        value: String,
    },
    /// A setting that is an option cannot be what it is.
    #[error(transparent)]
    Option(#[from] gnomon_options::OptionError),
    /// More of something than the adapter can hold.
    #[error("{what}: {wanted} wanted, adapter {adapter} allows {limit}")]
    OverLimit {
        /// What there is too much of.
        what: &'static str,
        /// How much was asked for.
        wanted: u64,
        /// How much there may be.
        limit: u64,
        /// Adapter name.
        adapter: String,
    },
    /// The shadow maps of a single light of each size are more than [`crate::TechniqueSettings::shadow_memory`].
    #[error(
        "shadow maps of one light of each size take {} MiB and the budget is {} MiB: raise the shadow memory or lower the shadow \
         resolution",
        wanted.div_ceil(1 << 20),
        budget >> 20
    )]
    OverBudget {
        /// Bytes needed at least.
        wanted: u64,
        /// Bytes there are.
        budget: u64,
    },
    /// The GPU reported a fault while it worked.
    #[error("the graphics device failed: {0}")]
    Device(String),
    /// The device is gone, as after a driver's reset: what was made with it is of no use any more.
    #[error("the graphics device was lost ({reason}): open it anew")]
    DeviceLost {
        /// The driver's words.
        reason: String,
    },
    /// What was drawn is no picture.
    #[error(
        "{pixels} pixels of the picture are NaN or infinite: a camera, material or light is, or the driver of adapter {adapter} is at \
         fault; choose another with --adapter"
    )]
    NotFinite {
        /// How many pixels.
        pixels: usize,
        /// Adapter name.
        adapter: String,
    },
    /// Layers are asked for where there are none.
    #[error("there are no layers: {reason}")]
    NoLayers {
        /// Why.
        reason: &'static str,
    },
    /// A shader could not be put together: a fault of this library.
    #[error(transparent)]
    Shader(#[from] gnomon_shaders::ShaderError),
}
