//! The adapters of this machine.

use crate::kernel::shader::Variant;

/// An adapter of this machine.
#[derive(Clone)]
pub struct Adapter {
    pub(crate) adapter: wgpu::Adapter,
}

impl Adapter {
    /// All adapters, one entry for each interface that drives them.
    pub fn all() -> Vec<Adapter> {
        let mut descriptor = wgpu::InstanceDescriptor::new_without_display_handle();
        descriptor.backends = wgpu::Backends::VULKAN | wgpu::Backends::METAL | wgpu::Backends::DX12;
        let instance = wgpu::Instance::new(descriptor);
        let found = pollster::block_on(instance.enumerate_adapters(wgpu::Backends::all()));
        found.into_iter().map(|adapter| Adapter { adapter }).collect()
    }

    /// Name of the device, with the driver's interface.
    pub fn name(&self) -> String {
        let info = self.adapter.get_info();
        format!("{} ({})", info.name, info.backend)
    }

    /// Address on the PCI bus, such as `0000:3b:00.0`, which distinguishes equal devices; empty where the driver does
    /// not give it.
    pub fn pci_address(&self) -> String {
        self.adapter.get_info().device_pci_bus_id
    }

    /// Whether it is a software rasteriser on the processor.
    pub fn is_software(&self) -> bool {
        self.adapter.get_info().device_type == wgpu::DeviceType::Cpu
    }

    /// Driver and capabilities as text.
    pub fn description(&self) -> String {
        let info = self.adapter.get_info();
        let int64 = if self.has_int64() { "64-bit products" } else { "16-bit products" };
        let pci = if info.device_pci_bus_id.is_empty() { "" } else { ", PCI " };
        let address = info.device_pci_bus_id;
        format!("{:?}, driver {} {}, {int64}{pci}{address}", info.device_type, info.driver, info.driver_info)
    }

    /// Whether its shaders have 64-bit registers.
    pub fn has_int64(&self) -> bool {
        self.adapter.features().contains(wgpu::Features::SHADER_INT64)
    }

    /// The fastest variant of the kernels for this adapter.
    pub fn variant(&self) -> Variant {
        Variant { int64: self.has_int64(), checked: false, workgroup: 64 }
    }
}
