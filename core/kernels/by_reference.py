"""Pass many arrays to a jitted function as one pointer.

numba passes a named tuple by value, seven numbers for each array in it. To pass a dozen arrays so costs more than a
short step, and to inline every function that takes them makes the compiler slow. A reference is a pointer to the tuple
on the stack of the function that makes it; its fields are read as those of the tuple, and cannot be assigned.
"""

# mypy: disable-error-code="no-untyped-call"
# numba's constructors have no types

from __future__ import annotations

from typing import Any

from numba import types
from numba.core import cgutils
from numba.core.imputils import impl_ret_borrowed
from numba.core.typing.templates import AttributeTemplate
from numba.extending import infer_getattr, intrinsic, lower_getattr_generic, models, register_model

__all__ = ["by_reference"]


class Reference(types.Type):
    """The type of a pointer to a named tuple."""

    def __init__(self, target: Any) -> None:
        self.target = target
        super().__init__(f"Reference({target.name})")


@register_model(Reference)
class _Model(models.PrimitiveModel):
    def __init__(self, manager: Any, kind: Reference) -> None:
        super().__init__(manager, kind, manager.lookup(kind.target).get_value_type().as_pointer())


@infer_getattr
class _Fields(AttributeTemplate):
    key = Reference

    def generic_resolve(self, kind: Any, name: str) -> Any:  # type: ignore[override]
        return kind.target.types[kind.target.fields.index(name)] if name in kind.target.fields else None


@lower_getattr_generic(Reference)  # type: ignore[untyped-decorator]
def _load(context: Any, builder: Any, kind: Reference, pointer: Any, name: str) -> Any:
    k = kind.target.fields.index(name)
    field = builder.load(cgutils.gep_inbounds(builder, pointer, 0, k))
    return impl_ret_borrowed(context, builder, kind.target.types[k], field)


def _by_reference(_context: Any, value: Any) -> Any:
    """A reference to a named tuple, valid until the function returns that makes it."""

    def build(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        return cgutils.alloca_once_value(builder, arguments[0])

    return Reference(value)(value), build


by_reference: Any = intrinsic(_by_reference)
