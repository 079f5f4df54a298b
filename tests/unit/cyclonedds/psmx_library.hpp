// A library that is loaded as Cyclone DDS 11 loads a PSMX instance.
#pragma once

#include <dlfcn.h>

#include <gtest/gtest.h>

namespace ddssec::cyclonedds::psmx_library {

/// The library of a PSMX instance, loaded as Cyclone DDS 11 loads it.
class PsmxLibrary {
 public:
  PsmxLibrary() : handle_(dlopen(DDSSEC_PSMX_LIKE, RTLD_GLOBAL | RTLD_NOW)) {
    EXPECT_NE(handle_, nullptr) << dlerror();
  }
  ~PsmxLibrary() { dlclose(handle_); }
  PsmxLibrary(const PsmxLibrary&) = delete;
  PsmxLibrary& operator=(const PsmxLibrary&) = delete;

 private:
  void* handle_;
};

}  // namespace ddssec::cyclonedds::psmx_library
