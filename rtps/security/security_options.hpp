// The options that make a participant a secured one.
#pragma once

#include "plugins/spi/token.hpp"

namespace ddssec::spi {
class AccessControl;
class Authentication;
class Cryptography;
}  // namespace ddssec::spi

namespace ddssec::rtps {

/// The plugins, which the application creates and owns. They must outlive every participant that
/// uses them. Several participants may share them.
struct SecurityPlugins {
  spi::Authentication& authentication;
  spi::AccessControl& access_control;
  spi::Cryptography& cryptography;
};

/// Makes a participant a secured one.
struct SecurityOptions {
  SecurityPlugins plugins;
  /// Their names are those in plugins/spi/property_names.hpp.
  spi::PropertyList properties;
};

}  // namespace ddssec::rtps
