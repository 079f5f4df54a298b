// libpcap, which is loaded only where something is captured: it needs the libraries of D-Bus and
// systemd, and loading them takes longer than most commands.
#pragma once

#include <cstdio>
#include <pcap/pcap.h>

#include "base/result.hpp"

namespace ddssec::cli {

/// The functions of libpcap that ddssec calls, under their names without "pcap_" or "pcap_get_".
struct PcapLibrary {
  decltype(&::pcap_open_offline_with_tstamp_precision) open_offline_with_tstamp_precision;
  decltype(&::pcap_create) create;
  decltype(&::pcap_set_snaplen) set_snaplen;
  decltype(&::pcap_set_timeout) set_timeout;
  decltype(&::pcap_set_buffer_size) set_buffer_size;
  decltype(&::pcap_set_tstamp_precision) set_tstamp_precision;
  decltype(&::pcap_activate) activate;
  decltype(&::pcap_setnonblock) setnonblock;
  decltype(&::pcap_geterr) geterr;
  decltype(&::pcap_datalink) datalink;
  decltype(&::pcap_get_selectable_fd) selectable_fd;
  decltype(&::pcap_next_ex) next_ex;
  decltype(&::pcap_close) close;
  decltype(&::pcap_dump_fopen) dump_fopen;
  decltype(&::pcap_dump) dump;
  decltype(&::pcap_dump_flush) dump_flush;
  decltype(&::pcap_dump_close) dump_close;

  /// Loads the library at the first call; it stays until the process ends. For one thread only.
  /// Error: capture_unreadable.
  static Result<const PcapLibrary*> load();
};

}  // namespace ddssec::cli
