#pragma once

#include <cstddef>
#include <list>
#include <map>
#include <utility>

namespace headframe {

/// A map that tracks which entry was used least recently; its owner decides what to drop, and when. Not thread safe.
template <class Key, class Value>
class LruMap {
 public:
  /// Null if there is no such entry; otherwise it becomes the most recent one. The pointer is valid until the entry is
  /// dropped.
  Value* find(const Key& key) {
    const auto known = where_.find(key);
    if (known == where_.end()) return nullptr;
    entries_.splice(entries_.begin(), entries_, known->second);
    return &known->second->second;
  }

  /// The entry becomes the most recent one. There must be none with this key.
  Value& put(const Key& key, Value value) {
    entries_.emplace_front(key, std::move(value));
    where_[key] = entries_.begin();
    return entries_.front().second;
  }

  /// There must be an entry with this key.
  Value drop(const Key& key) {
    const auto known = where_.find(key);
    Value value = std::move(known->second->second);
    entries_.erase(known->second);
    where_.erase(known);
    return value;
  }
  Value drop_oldest() { return drop(Key(entries_.back().first)); }

  template <class Visit>
  void each_key(Visit visit) const {
    for (const auto& [key, value] : entries_) visit(key);
  }

  std::size_t size() const { return entries_.size(); }

 private:
  std::list<std::pair<Key, Value>> entries_;  // most recently used first
  std::map<Key, typename std::list<std::pair<Key, Value>>::iterator> where_;
};

}  // namespace headframe
