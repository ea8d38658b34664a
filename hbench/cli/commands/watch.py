"""``hbench watch``: local page of a campaign, for a screen beside the bench."""

from pathlib import Path

import typer


def watch(
    campaign: Path = typer.Argument(
        help="Campaign folder, or with --station a folder of campaigns; need not exist yet."
    ),
    station: bool = typer.Option(
        False,
        "--station",
        help="Follow the newest campaign in the folder, with its decision in large letters and the "
        "last twenty cylinders.",
    ),
    port: int = typer.Option(
        8350, min=0, max=65535, help="TCP port on this machine; 0 for any free port."
    ),
) -> None:
    """Show CAMPAIGN on a local web page, during and after measurement. Ctrl-C ends it.

    Only this machine can open the page. The command only reads: 'hbench run' in another terminal
    does not depend on it.

    Example: hbench watch demo
    """
    from hbench import workflow
    from hbench.cli.watch_server import new_server
    from hbench.errors import ConfigError

    if campaign.is_file():
        raise ConfigError(f"{campaign}: is a file", "Give the campaign's folder.")
    is_campaign = (campaign / "campaign.yaml").is_file()
    if station and is_campaign:
        raise ConfigError(
            f"{campaign}: is a campaign", "Give the folder of campaigns, or leave out --station."
        )
    if not (station or is_campaign) and any(campaign.glob("*/campaign.yaml")):
        raise ConfigError(
            f"{campaign}: is a folder of campaigns",
            "Give one of them, or --station, which follows the newest one.",
        )
    if not campaign.exists():
        typer.echo(f"note: {campaign}: does not exist yet; the page waits for it", err=True)
    server = new_server((workflow.Station if station else workflow.Watch)(campaign), port)
    try:
        print(f"http://127.0.0.1:{server.server_port}/", flush=True)  # for a reader of a pipe
        server.serve_forever()
    except KeyboardInterrupt:
        return
    finally:
        server.server_close()
