//! Permission to read hidraw devices: udev knows no usage pages, so a rule names vendor and product.

/// The rule that gives whoever sits at the machine access to one kind of device, on whatever bus it is: the
/// kernel names its parent `BUS:VENDOR:PRODUCT.NUMBER` in capital hex, while `ATTRS{idVendor}` is there on
/// USB only.
#[must_use]
pub fn rule(vendor_id: u16, product_id: u16) -> String {
    format!(r#"KERNEL=="hidraw*", KERNELS=="*:{vendor_id:04X}:{product_id:04X}.*", TAG+="uaccess""#)
}

/// Where the rule belongs. Its number must lie before 73, where udev acts on the tag.
#[must_use]
pub fn rule_path(vendor_id: u16, product_id: u16) -> String {
    format!("/etc/udev/rules.d/70-macula-{vendor_id:04x}-{product_id:04x}.rules")
}

/// What to do where a device may not be opened; one line.
#[must_use]
pub fn advice(vendor_id: u16, product_id: u16) -> String {
    format!(
        "no permission; write the line '{}' to {} as root, run 'udevadm control --reload-rules && udevadm \
         trigger' as root, then plug the device in again",
        rule(vendor_id, product_id),
        rule_path(vendor_id, product_id)
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_rule_names_vendor_and_product_as_the_kernel_does() {
        let expected = r#"KERNEL=="hidraw*", KERNELS=="*:04D8:00FF.*", TAG+="uaccess""#;
        assert_eq!(rule(0x04d8, 0xff), expected);
        let advice = advice(0x04d8, 0xff);
        assert!(advice.contains(expected) && advice.contains("/etc/udev/rules.d/70-macula-04d8-00ff.rules"));
        assert!(!advice.contains('\n'));
    }
}
