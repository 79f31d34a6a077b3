// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "field_storage.hpp"
#include "model.hpp"
#include "pipescout/idl/message_type.hpp"
#include "pipescout/idl/support/object_type.hpp"

namespace pipescout::idl {

/// A type made at run time from its definition, with the same field table as a generated one. Not
/// destroyed before the process ends, since messages and endpoints refer to it.
class LoadedType final : public ObjectType {
 public:
  /// `nested`: gives the type of a field that is a message; what it throws goes through. Throws
  /// MessageTypeError when the process has loaded as many types as it can.
  LoadedType(const generator::Structure& structure,
             const std::function<const ObjectType&(const generator::Field& field)>& nested);

  [[nodiscard]] const MessageType& type() const noexcept override { return type_; }
  [[nodiscard]] std::size_t size() const noexcept override { return size_; }
  [[nodiscard]] std::size_t alignment() const noexcept override { return alignment_; }

  void construct(void* memory) const override;
  void relocate(void* memory, void* from) const noexcept override;
  void destroy(void* message) const noexcept override;
  void write(CdrWriter& cdr, const void* message) const override;
  void read(CdrReader& cdr, void* message) const override;
  void measure(CdrSize& cdr, const void* message) const override;

  /// As MessageType::create.
  [[nodiscard]] std::shared_ptr<void> create() const;

 private:
  struct Part {
    std::unique_ptr<FieldStorage> storage;
    std::size_t offset = 0;
  };
  struct Texts {
    std::string name;
    std::string value;  ///< of a constant; of a field its default, or empty
  };

  std::string name_;
  std::string dds_name_;
  std::string definition_;
  std::vector<Part> parts_;
  std::vector<Texts> field_texts_;
  std::vector<Texts> constant_texts_;
  std::vector<MessageField> fields_;
  std::vector<MessageConstant> constants_;
  std::size_t size_ = 0;
  std::size_t alignment_ = 1;
  MessageType type_;
};

}  // namespace pipescout::idl
