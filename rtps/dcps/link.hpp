// A list of objects that know their position in it.
#pragma once

#include <list>

namespace ddssec::rtps {

template <class T>
using LinkedList = std::list<T*>;

/// An object's membership in at most one list. Entering and leaving a list allocates nothing.
template <class T>
class Link {
 public:
  explicit Link(T* self) : own_{self}, at_(own_.begin()) {}
  ~Link() { leave(); }
  Link(const Link&) = delete;
  Link& operator=(const Link&) = delete;

  bool linked() const { return in_ != nullptr; }
  /// Leaves the current list, if any, and moves to the end of `list`.
  void append_to(LinkedList<T>& list) {
    leave();
    list.splice(list.end(), own_);
    in_ = &list;
  }
  void leave() {
    if (in_ != nullptr) own_.splice(own_.begin(), *in_, at_);
    in_ = nullptr;
  }

 private:
  LinkedList<T> own_;
  typename LinkedList<T>::iterator at_;
  LinkedList<T>* in_ = nullptr;
};

}  // namespace ddssec::rtps
