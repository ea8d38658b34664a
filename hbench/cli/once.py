"""Command whose options can be given once."""

from typing import Any

from typer.core import TyperCommand


class OnceCommand(TyperCommand):
    """Command that refuses a repeated option, whose last value would replace the others.

    A flag without an opposite, such as ``--json``, may be repeated.
    """

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Parse the arguments. Raises ``UsageError`` for a repeated option."""
        _, _, order = self.make_parser(ctx).parse_args(args=list(args))
        given = set()
        for option in order:
            if option.param_type_name == "argument" or getattr(option, "multiple", False):
                continue
            if getattr(option, "is_flag", False) and not option.secondary_opts:
                continue
            if option.name in given and not ctx.resilient_parsing:
                names = " / ".join([*option.opts, *option.secondary_opts])
                ctx.fail(f"Option '{names}' is given more than once; give it once.")
            given.add(option.name)
        return super().parse_args(ctx, args)
