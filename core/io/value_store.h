#ifndef ARBORSLAM_CORE_IO_VALUE_STORE_H_
#define ARBORSLAM_CORE_IO_VALUE_STORE_H_

#include <cstddef>
#include <cstdint>
#include <list>
#include <memory>
#include <mutex>
#include <string>
#include <type_traits>
#include <utility>

#include "core/io/binary_archive.h"

namespace arborslam {

/// Keeps values in memory up to a limit, besides those that are in use. Beyond it, the ones not asked for longest lie
/// in a file, from which they are read back on demand. The file has no name: it is gone with the store, however the
/// program ends. For any number of threads.
class ValueStore {
 public:
  /// @param folder    where the file is made when it is first needed.
  /// @param max_bytes of the values in memory, as `BinaryWriter` writes them.
  ValueStore(std::string folder, size_t max_bytes);
  ~ValueStore();
  ValueStore(const ValueStore&) = delete;
  ValueStore& operator=(const ValueStore&) = delete;

  /// Bytes of the values that it keeps in memory at present.
  size_t bytes_in_memory() const;
  /// Bytes that were written to the file.
  uint64_t bytes_in_file() const;

 private:
  template <class T>
  friend class Stored;

  // A value's place.
  class Slot {
   public:
    virtual ~Slot() = default;

   private:
    friend class ValueStore;
    virtual std::string Bytes() const = 0;
    virtual void Forget() = 0;
    virtual void Restore(const std::string& bytes, const std::string& place) = 0;

    size_t size_ = 0;                    // [bytes]
    std::list<Slot*>::iterator listed_;  // If it is in memory.
    bool is_in_memory_ = false;
    bool is_in_file_ = false;
    uint64_t offset_ = 0;  // In the file.
  };

  // All but `Add` and `Remove` are for callers that hold the lock.
  void Add(Slot* slot);
  void Remove(Slot* slot);
  // Brings the slot's value to memory.
  void Use(Slot* slot);
  void List(Slot* slot);
  void Unlist(Slot* slot);
  // Until `size` more bytes are within the limit, or nothing is in memory.
  void MakeRoom(size_t size);
  void Write(Slot* slot);
  std::string Read(const Slot& slot) const;
  [[noreturn]] void Fail(const char* what) const;

  std::string folder_;
  size_t max_bytes_;
  mutable std::mutex mutex_;
  std::list<Slot*> in_memory_;  // Last used first.
  size_t bytes_in_memory_ = 0;
  int file_ = -1;
  uint64_t file_size_ = 0;
};

/// A value that does not change, in memory or in the care of a `ValueStore`. Copies share it.
template <class T>
class Stored {
 public:
  /// T(), which costs no memory.
  Stored() = default;
  /// In memory.
  Stored(T value) : value_(std::make_shared<const T>(std::move(value))) {}
  /// In the care of `store`; null: in memory. Throws `UserError` when the file cannot be written.
  Stored(T value, const std::shared_ptr<ValueStore>& store) {
    if (store == nullptr) {
      value_ = std::make_shared<const T>(std::move(value));
    } else {
      slot_ = std::make_shared<TypedSlot>(std::move(value), store);
    }
  }

  /// The same value in the care of `store`; null: this one.
  Stored MovedTo(const std::shared_ptr<ValueStore>& store) const {
    return store == nullptr ? *this : Stored(T(*Get()), store);
  }
  /// Another value in the care that this one is in.
  Stored Replaced(T value) const { return Stored(std::move(value), slot_ != nullptr ? slot_->store() : nullptr); }

  /// The value, which stays in memory as long as the pointer is kept. Throws `UserError` when it cannot be read back.
  std::shared_ptr<const T> Get() const {
    if (slot_ != nullptr) return slot_->Get();
    if (value_ != nullptr) return value_;
    static const std::shared_ptr<const T> kDefault = std::make_shared<const T>();
    return kDefault;
  }

  /// Written as the value; read into memory.
  template <class Visitor>
  void VisitState(Visitor&& visit) {
    if constexpr (std::decay_t<Visitor>::kIsReading) {
      T value;
      visit(value);
      *this = Stored(std::move(value));
    } else {
      visit(*Get());
    }
  }

 private:
  class TypedSlot final : public ValueStore::Slot {
   public:
    TypedSlot(T value, std::shared_ptr<ValueStore> store)
        : store_(std::move(store)), value_(std::make_shared<const T>(std::move(value))) {
      store_->Add(this);
    }
    ~TypedSlot() override { store_->Remove(this); }

    const std::shared_ptr<ValueStore>& store() const { return store_; }
    std::shared_ptr<const T> Get() {
      const std::lock_guard<std::mutex> lock(store_->mutex_);
      store_->Use(this);
      return value_;
    }

   private:
    std::string Bytes() const override {
      BinaryWriter writer;
      writer(*value_);
      return writer.bytes();
    }
    void Forget() override { value_.reset(); }
    void Restore(const std::string& bytes, const std::string& place) override {
      T value;
      BinaryReader reader(bytes, place);
      reader(value);
      reader.CheckEnd();
      value_ = std::make_shared<const T>(std::move(value));
    }

    std::shared_ptr<ValueStore> store_;
    std::shared_ptr<const T> value_;  // Null when it is in the file only.
  };

  std::shared_ptr<const T> value_;
  std::shared_ptr<TypedSlot> slot_;
};

}  // namespace arborslam

#endif  // ARBORSLAM_CORE_IO_VALUE_STORE_H_
