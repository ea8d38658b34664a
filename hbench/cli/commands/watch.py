"""``hbench watch``: a campaign on a local page, for the screen beside the bench."""

from pathlib import Path

import typer


def watch(
    campaign: Path = typer.Argument(help="Campaign folder; it may not be there yet."),
    port: int = typer.Option(
        8350, min=0, max=65535, help="TCP port on this machine; 0 takes any that is free."
    ),
) -> None:
    """Show CAMPAIGN on a page of this machine alone, while it is made and after. Ctrl-C ends it.

    It only reads; what 'hbench run' does in another terminal goes on without it.

    Example: hbench watch demo
    """
    from hbench import workflow
    from hbench.cli.watch_server import new_server

    server = new_server(workflow.Watch(campaign), port)
    try:
        print(f"http://127.0.0.1:{server.server_port}/", flush=True)  # a pipe's reader waits for it
        server.serve_forever()
    except KeyboardInterrupt:
        return
    finally:
        server.server_close()
